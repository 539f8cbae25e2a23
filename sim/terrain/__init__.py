"""The true ground: generators and files."""
