"""The other end of the bench of the bus: answers over zenoh and over plain TCP.

    python -m sceneq_tools.bench.echo ENDPOINT      # prints its TCP port; ends with its input

A get on ``GET`` with parameter ``n`` is answered by n bytes; each frame on ``FRAMES`` by a byte on
``TAKEN``. Over TCP, a request is its size and the size of the answer, then that many bytes.
"""

import socket
import struct
import sys
import threading
from typing import Any

from sceneq_nodes._runtime import close, open_session

GET, FRAMES, TAKEN = "sceneq/@bench/get", "sceneq/@bench/frames", "sceneq/@bench/taken"
HEADER = struct.Struct("<II")
CONNECT_S = 10.0


def main() -> None:
    """Answer until standard input ends."""
    session = open_session(sys.argv[1], CONNECT_S)
    taken = session.declare_publisher(TAKEN)
    kept_alive = (
        session.declare_queryable(GET, _reply),
        session.declare_subscriber(FRAMES, lambda sample: taken.put(b".")),
    )
    listener = socket.create_server(("127.0.0.1", 0))
    threading.Thread(target=_serve, args=(listener,), daemon=True).start()
    print(listener.getsockname()[1], flush=True)
    sys.stdin.read()
    close(session)
    del kept_alive


def exchange(connection: socket.socket, request: bytes, answer_size: int) -> bytes:
    """Send a request over TCP and return the answer."""
    send(connection, request, answer_size)
    return receive(connection, answer_size)


def send(connection: socket.socket, request: bytes, answer_size: int) -> None:
    """Send a request whose answer is read later."""
    connection.sendall(HEADER.pack(len(request), answer_size))
    connection.sendall(request)


def receive(connection: socket.socket, size: int) -> bytes:
    """Return the next ``size`` bytes; raise ``ConnectionError`` when they do not come."""
    data = bytearray(size)
    view, got = memoryview(data), 0
    while got < size:
        count = connection.recv_into(view[got:])
        if not count:
            raise ConnectionError("the other end has closed")
        got += count
    return bytes(data)


def _reply(query: Any) -> None:
    with query:
        query.reply(GET, bytes(int(str(query.parameters).partition("=")[2])))


def _serve(listener: socket.socket) -> None:
    connection, _ = listener.accept()
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    with connection:
        try:
            while True:
                size, answer_size = HEADER.unpack(receive(connection, HEADER.size))
                receive(connection, size)
                connection.sendall(bytes(answer_size))
        except ConnectionError:
            return


if __name__ == "__main__":
    main()
