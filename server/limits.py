"""What clients may take of the console: one place for every limit of its web side.

A limit that is too low turns people away; one that is too high lets one client starve the others.
"""

from __future__ import annotations

# connections

CONNECTIONS_MAX = 320  # of all clients; a page takes three, and each needs a descriptor
CONNECTIONS_PER_ADDRESS = 128  # a class behind one router; not for this computer, where proxies are
DESCRIPTORS_KEPT = 192  # for files, children and what is being accepted just now
ACCEPTED_AT_ONCE = 32  # in one turn of the loop; more: their descriptors run out in a rush
QUEUED_MAX = 1024  # waiting connections that the system keeps for us; fewer: a rush turns away
FIRST_REQUEST_TIME = 5.0  # s from connecting to a whole request head
IDLE_TIME = 5  # s between two requests

# requests

HEAD_MAX = 16 * 1024  # bytes of a request line and its headers
BODY_MAX = 1024 * 1024  # bytes
BODY_TIME = 10.0  # s a body may take
UPLOAD_TIME = 120.0  # s a file may take
JSON_DEPTH_MAX = 32  # brackets within brackets
NUMBER_MAX = 64  # characters of one number: a float has 24
LOADS_AT_ONCE = 1  # worlds being made
DRAWS_AT_ONCE = 1  # replays of runs being drawn, and curves of sweeps
DISK_LOOKS_AT_ONCE = 4  # into the data folder
DISK_TIME = 5.0  # s one may take
TEXT_FILE_MAX = 4 * 1024 * 1024  # bytes that are read of a text file there
DRAWINGS_ASKED_MAX = 8  # requests that wait for one

# the log

LOG_LETTERS = 500_000  # letters within LOG_WINDOW; what is more is counted, not written
LOG_WINDOW = 60.0  # s

# tokens

GUESSES_MAX = 10  # wrong ones from one address within GUESSES_WITHIN, after which it waits
GUESSES_WITHIN = 60.0  # s
ADDRESSES_KEPT = 512  # that have shown wrong ones, and as many that have shown right ones

# WebSockets

SOCKETS_PER_SECOND = 50.0  # new ones of one address; more: stops over HTTP wait behind them
SOCKETS_BURST = 100.0  # new ones at once: a class that comes back
WRITE_BUFFER = 32 * 1024  # bytes waiting for a slow client; more, and it sees the past
SOCKET_FRAME_MAX = 64 * 1024  # bytes of any frame
PING_EVERY = 5.0  # s
PING_TIME = 10.0  # s; a canvas on a slow line answers behind the ground it is still being sent
CUT_AFTER = 0.3  # s from a close code to the end of the connection, whatever the client does

DRIVERS_MAX = 32  # sockets on /drive
DRIVE_FRAME_MAX = 4096  # bytes
DRIVE_PING_EVERY = 1.0  # s; a page that is stuck must not keep its place
DRIVE_PING_TIME = 3.0  # s
DRIVE_SEND_TIME = 5.0  # s a page may take for one snapshot before it is cut
DRIVE_FRAMES_PER_SECOND = 100.0
DRIVE_BURST = 50.0  # frames
# frames: what five seconds without a link may hold back and deliver at once
DRIVE_BURST_AFTER_SILENCE = 500.0

CANVASES_MAX = 16
CANVAS_FRAME_MAX = 16 * 1024  # bytes from a client; a camera message has about 300
CANVAS_MESSAGES_PER_SECOND = 240.0  # a camera that follows the mouse sends one a frame
CANVAS_BURST = 240.0  # messages
# s a client may take for one frame before it is cut; the first one carries the whole ground
CANVAS_SEND_TIME = 30.0
