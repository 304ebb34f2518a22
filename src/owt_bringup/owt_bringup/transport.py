"""Shared memory between the nodes of one machine, large enough for the blocks in flight.

The default segment of Fast DDS (0.5 MB) is smaller than one block of a usual case. Blocks then travel
over UDP in fragments, and each lost fragment waits for a heartbeat: measured, a run took eight times as
long. Where shared memory is scarce (containers), the default stays: slower, and as lossless.

The period of the later announcements is left at its default of 3 s: Fast DDS 3.2.3 can deadlock when a
peer's writer is removed in the very moment of an announcement (seen once with a period of 0.2 s).
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["PROFILE_VARIABLE", "quick_acknowledgements", "shared_memory_profile"]

#: Environment variable that Fast DDS reads; a user's own profile is left in place.
PROFILE_VARIABLE = "FASTDDS_DEFAULT_PROFILES_FILE"
_SEGMENT, _SMALLEST = 32 << 20, 4 << 20
_SHARED_MEMORY = Path("/dev/shm")
_PROFILE = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com">
  <profiles>
    <transport_descriptors>
      <transport_descriptor>
        <transport_id>shared_memory</transport_id>
        <type>SHM</type>
        <segment_size>{segment}</segment_size>
        <maxMessageSize>{message}</maxMessageSize>
      </transport_descriptor>
      <transport_descriptor>
        <transport_id>udp</transport_id>
        <type>UDPv4</type>
      </transport_descriptor>
    </transport_descriptors>
    <participant profile_name="owt" is_default_profile="true">
      <rtps>
        <userTransports>
          <transport_id>shared_memory</transport_id>
          <transport_id>udp</transport_id>
        </userTransports>
        <useBuiltinTransports>false</useBuiltinTransports>
        <builtin>
          <discovery_config>
            <initialAnnouncements>
              <count>10</count>
              <period><sec>0</sec><nanosec>100000000</nanosec></period>
            </initialAnnouncements>
          </discovery_config>
        </builtin>
      </rtps>
    </participant>
  </profiles>
</dds>
"""
_BARE = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com">
  <profiles>
  </profiles>
</dds>
"""
_WRITER = """    <data_writer profile_name="owt_writer" is_default_profile="true">
      <times><heartbeat_period><sec>0</sec><nanosec>5000000</nanosec></heartbeat_period></times>
    </data_writer>
"""


def shared_memory_profile(participants: int, folder: Path = _SHARED_MEMORY) -> str | None:
    """Return a Fast DDS profile for `participants` processes, or None where memory is too scarce.

    No more than half of what is free is taken: beyond the limit of the file system a process would be
    killed when it touches its segment.
    """
    try:
        free = shutil.disk_usage(folder).free
    except OSError:
        return None
    segment = min(_SEGMENT, free // (2 * participants))
    if segment < _SMALLEST:
        return None
    return _PROFILE.format(segment=segment, message=segment // 2)


@contextmanager
def quick_acknowledgements() -> Iterator[bool]:
    """Let writers of this process ask their readers often what they have, while the block lasts.

    By default they ask every 3 s; who waits for the answer before it sends more comes to a few messages per
    second. Fast DDS reads the profile once, before the first participant. A user's own profile stays: yields
    False then.
    """
    if PROFILE_VARIABLE in os.environ:
        yield False
        return
    with tempfile.TemporaryDirectory(prefix="owt-fastdds-") as folder:
        path = Path(folder) / "fastdds.xml"
        profile = shared_memory_profile(2) or _BARE
        path.write_text(profile.replace("  </profiles>", f"{_WRITER}  </profiles>"), encoding="utf-8")
        os.environ[PROFILE_VARIABLE] = str(path)
        try:
            yield True
        finally:
            os.environ.pop(PROFILE_VARIABLE, None)
