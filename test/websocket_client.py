"""As much of a WebSocket client as tests need to be a Foxglove viewer: it subscribes to all there is."""

import base64
import json
import os
import socket
import struct
from typing import Any


class FoxgloveClient:
    """One connection; a context manager."""

    def __init__(self, port: int, host: str = "127.0.0.1") -> None:
        self._socket = socket.create_connection((host, port), timeout=10.0)
        key = base64.b64encode(os.urandom(16)).decode()
        request = (
            f"GET / HTTP/1.1\r\nHost: {host}:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
        )
        self._socket.sendall(request.encode())
        self._stream = self._socket.makefile("rb")
        status = self._stream.readline()
        assert b" 101 " in status, status
        while self._stream.readline() != b"\r\n":
            pass
        self.channels: dict[int, dict[str, Any]] = {}

    def __enter__(self) -> "FoxgloveClient":
        return self

    def __exit__(self, *_: object) -> None:
        self._stream.close()
        self._socket.close()

    def _send(self, text: str) -> None:
        data, mask = text.encode(), os.urandom(4)
        length = bytes([0x80 | len(data)]) if len(data) < 126 else struct.pack(">BH", 0xFE, len(data))
        masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(data))
        self._socket.sendall(b"\x81" + length + mask + masked)

    def _frame(self) -> tuple[int, bytes]:
        first, length = self._stream.read(2)
        if length > 125:
            (length,) = struct.unpack(
                *((">H", self._stream.read(2)) if length == 126 else (">Q", self._stream.read(8)))
            )
        return first & 0x0F, self._stream.read(length)

    def message(self) -> tuple[str, int, bytes]:
        """Return topic, time in ns and payload of the next message; subscribe to what is offered."""
        while True:
            kind, data = self._frame()
            if kind == 1 and json.loads(data)["op"] == "advertise":
                offered = json.loads(data)["channels"]
                self.channels |= {channel["id"]: channel for channel in offered}
                wanted = [{"id": channel["id"], "channelId": channel["id"]} for channel in offered]
                self._send(json.dumps({"op": "subscribe", "subscriptions": wanted}))
            elif kind == 2 and data[0] == 1:
                subscription, time_ns = struct.unpack_from("<IQ", data, 1)
                return self.channels[subscription]["topic"], time_ns, data[13:]
