"""The physics plant: the machine as rigid bodies on servo-driven legs, in MuJoCo."""
