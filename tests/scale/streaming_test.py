#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A network trained on samples that are read from a disk in parts: the same bytes by any number of workers, killed and resumed;
and each way in which what is read is damaged or there is no room for it ends with one line.

    streaming_test.py CASE PROGRAM
"""
import signal

from training_testing import SMALL_NETWORK, Place, ended, failed_with, run_case, succeeded

FRAMES = 2100  # two whole blocks, and one of what is left
MANIFEST = """
seed = 3
frames = 2200
[body]
people = 1
[camera]
width = 64
height = 48
fx = 45.0
fy = 45.0
cx = 31.5
cy = 23.5
[placement]
nearest_mm = 350.0
farthest_mm = 500.0
off_centre = 0.05
presented_share = 1.0
"""
CONFIG = """
source = 'synthetic:{manifest}?count={frames}'
validation = 'synthetic:{manifest}?first=2100&count=4'
start = 'truth'
[patch]
mode = 'cube'
size_px = 32
[samples]
crop_px = 48
centre = 'joints'
stream = {stream}
stream_window = {window}
memory_gb = {memory_gb}
""" + SMALL_NETWORK + """
[training]
epochs = {epochs}
batch_size = 24
shards = 6
validate_every = 20
"""


class StreamingPlace(Place):
    """A place with a manifest of small images."""

    def __init__(self, program, folder):
        super().__init__(program, folder)
        (folder / "small.toml").write_text(MANIFEST)

    def command(self, out, *more, cache="cache", frames=FRAMES, stream="true", window=1100, memory_gb=0.001, epochs=1.5):
        config = self.folder / f"{out}.train.toml"
        config.write_text(CONFIG.format(manifest=self.folder / "small.toml", frames=frames, stream=stream, window=window,
                                        memory_gb=memory_gb, epochs=epochs))
        cached = ["--cache", self.folder / cache] if cache else []
        return [self.program, "train", "network", "--config", config, "--out", self.folder / out, *cached, *map(str, more)]

    def train(self, *arguments, **options):
        return succeeded(self.start(self.command(*arguments, **options)))

    def blocks(self):
        return sorted((self.folder / "cache").glob("samples_*/block_*.h5"))


def same_bytes(place):
    place.train("1.pt")
    assert len(place.blocks()) == 3, place.blocks()
    for workers in (2, 3):
        place.train(f"{workers}.pt", "--workers", workers)
    place.train("more_memory.pt", "--threads", 1, memory_gb=1)
    assert place.bytes_of("1.pt") == place.bytes_of("2.pt") == place.bytes_of("3.pt") == place.bytes_of("more_memory.pt")
    # Where one window holds all samples, they come in the order of memory.
    place.train("memory.pt", stream="false", memory_gb=1, frames=300, epochs=4)
    for cache in ("cache", None):
        place.train("streamed.pt", cache=cache, frames=300, epochs=4)
        assert place.bytes_of("streamed.pt") == place.bytes_of("memory.pt"), cache
    assert place.bytes_of("1.pt") != place.bytes_of("memory.pt")


def resumed(place):
    place.train("whole.pt")
    for workers in (1, 2):
        process = place.start(place.command("parts.pt"))
        place.wait_for_checkpoint("parts.pt", process)
        process.kill()
        assert ended(process)[0] == -signal.SIGKILL, "faster than its killer"
        place.train("parts.pt", "--resume", "--workers", workers)
        assert place.bytes_of("parts.pt") == place.bytes_of("whole.pt"), workers
        (place.folder / "parts.pt.checkpoint").unlink()
    # Killed and interrupted while hands are cut out: what is whole is kept.
    folder = next((place.folder / "cache").glob("samples_*/index.h5")).parent
    for sent, status in ((signal.SIGKILL, -signal.SIGKILL), (signal.SIGINT, 1)):
        for block in place.blocks():
            block.unlink()
        process = place.start(place.command("again.pt"))
        place.wait_for(folder / "block_000000.h5", process)
        process.send_signal(sent)
        assert ended(process)[0] == status, "faster than its killer"
        written = (folder / "block_000000.h5").stat().st_mtime_ns
    place.train("again.pt")
    assert (folder / "block_000000.h5").stat().st_mtime_ns == written
    assert place.bytes_of("again.pt") == place.bytes_of("whole.pt")


def damaged(place):
    place.train("net.pt")
    block = place.blocks()[1]
    whole = block.read_bytes()
    block.write_bytes(whole[:-100])
    failed_with(place.start(place.command("net.pt")), block.name, "bytes", "remove the file")
    middle = bytearray(whole)
    for i in range(len(whole) // 4, len(whole) // 2):
        middle[i] ^= 0x55
    block.write_bytes(middle)
    for workers in (1, 2):
        failed_with(place.start(place.command("net.pt", "--workers", workers)), block.name)
    block.unlink()
    place.train("net.pt")
    # Interrupted, and a block taken away, while it is read.
    process = place.start(place.command("long.pt", epochs=400))
    place.wait_for_checkpoint("long.pt", process)
    process.send_signal(signal.SIGINT)
    failed_with(process, "interrupted after", "--resume")
    process = place.start(place.command("lost.pt", epochs=400))
    place.wait_for_checkpoint("lost.pt", process)
    for block in place.blocks():
        block.unlink()
    failed_with(process, "block_", "missing")


def full_disk(place):
    limited = place.start(place.command("net.pt"), longest_file=60000)
    failed_with(limited, "block_000000", "is the disk full")
    assert not place.blocks() and not (place.folder / "net.pt").exists()
    failed_with(place.start(place.command("net.pt", stream="false")), "memory_gb", "stream = true")
    failed_with(place.start(place.command("net.pt", memory_gb=0.0001)), "memory_gb", "two batches")


if __name__ == "__main__":
    run_case(StreamingPlace, same_bytes, resumed, damaged, full_disk)
