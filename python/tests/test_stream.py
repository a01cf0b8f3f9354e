"""Streams, threads, and what a program needs of Python meanwhile."""

import gc
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import gpu_stereo

Pair = tuple[np.ndarray, np.ndarray]


def shifted(small: Pair, shift: int) -> Pair:
    return np.roll(small[0], shift, 0), np.roll(small[1], shift, 0)


def devices() -> list[Any]:
    return ["cpu", *(adapter.index for adapter in gpu_stereo.adapters()[:1])]


@pytest.mark.parametrize("in_flight", [1, 3])
def test_results_come_in_order(small: Pair, in_flight: int) -> None:
    for device in devices():
        matcher = gpu_stereo.StereoMatcher(160, 96, disparities=32, device=device)
        pairs = [shifted(small, shift) for shift in range(7)]
        expected = [matcher.compute(*pair).raw for pair in pairs]
        for stream in (
            matcher.stream(pairs, in_flight),
            matcher.stream(iter(pairs), in_flight),
            gpu_stereo.stream(pairs, 32, device=device, in_flight=in_flight),
        ):
            found = [matched.raw for matched in stream]
            assert len(found) == 7
            for one, other in zip(found, expected, strict=True):
                np.testing.assert_array_equal(one, other)
            assert list(stream) == []


def test_no_more_pairs_are_fetched_than_may_be_in_flight(small: Pair) -> None:
    fetched = []

    def pairs() -> Iterator[Pair]:
        for shift in range(6):
            fetched.append(shift)
            yield shifted(small, shift)

    stream = gpu_stereo.stream(pairs(), 16, device="cpu", in_flight=2)
    assert fetched == []
    next(stream)
    assert fetched == [0, 1]
    next(stream)
    assert fetched == [0, 1, 2]
    del stream  # with pairs in flight


def test_an_exception_comes_after_the_results_before_it(small: Pair) -> None:
    class Interrupted(Exception):
        pass

    def failing() -> Iterator[Any]:
        yield small
        yield small
        raise Interrupted

    for device in devices():
        stream = gpu_stereo.stream(failing(), 16, device=device, in_flight=4)
        assert len([next(stream), next(stream)]) == 2
        with pytest.raises(Interrupted):
            next(stream)
        with pytest.raises(StopIteration):
            next(stream)
        for wrong, text in [
            ((small[0][1:], small[1][1:]), "the images are 160x95, but the matcher was made for 160x96"),
            ((small[0],), "a pair"),
            (None, "a pair"),
            ((small[0].astype("uint16"), small[1].astype("uint16")), "samples of the kind Gray16"),
            ((small[0].astype("float32"), small[1]), "samples of float32"),
        ]:
            stream = gpu_stereo.stream([small, wrong, small], 16, device=device)
            next(stream)
            with pytest.raises(gpu_stereo.InputError, match=text):
                next(stream)
            assert list(stream) == []


def test_what_is_no_stream() -> None:
    with pytest.raises(TypeError):
        gpu_stereo.stream(3, 16)  # type: ignore[arg-type]
    for in_flight in (0, -1, 17):
        with pytest.raises(gpu_stereo.InputError, match=f"in_flight is {in_flight}, but must be from 1 to 16"):
            gpu_stereo.stream([], 16, in_flight=in_flight)
    assert list(gpu_stereo.stream([], 16)) == []
    with pytest.raises(gpu_stereo.InputError, match="p2 is 900"):
        gpu_stereo.stream([], 16, p2=900)
    with pytest.raises(gpu_stereo.InputError, match="the range of a single pair"):
        list(gpu_stereo.stream([np.zeros((2, 8, 40), "uint8")], "auto", device="cpu"))  # type: ignore[arg-type]


def test_the_bits_of_a_stream_are_those_of_its_first_pair(small: Pair) -> None:
    ten = [image.astype("uint16") << 2 for image in small]
    dark = [image // 16 for image in ten]
    first, second = gpu_stereo.stream([ten, dark], 32, device="cpu")
    np.testing.assert_array_equal(first.raw, gpu_stereo.match(*ten, 32, device="cpu").raw)
    np.testing.assert_array_equal(second.raw, gpu_stereo.match(*dark, 32, device="cpu", bits=10).raw)


def test_other_threads_run_meanwhile(motorcycle: Pair) -> None:
    """While a pair is computed, another thread counts; were Python held, it would count nothing."""
    counted, stop = 0, False

    def count() -> None:
        nonlocal counted
        while not stop:
            counted += 1
            time.sleep(0)

    matcher = gpu_stereo.StereoMatcher(741, 500, "dense", 64, "cpu")
    matcher.compute(*motorcycle)
    thread = threading.Thread(target=count)
    thread.start()
    try:
        before = counted
        matcher.compute(*motorcycle)
        during = counted - before
    finally:
        stop = True
        thread.join()
    assert during > 100, during


def test_threads_may_share_a_matcher(small: Pair) -> None:
    for device in devices():
        matcher = gpu_stereo.StereoMatcher(160, 96, disparities=32, device=device)
        pairs = [shifted(small, shift) for shift in range(4)]
        expected = [matcher.compute(*pair).raw for pair in pairs]
        found: list[list[np.ndarray]] = [[] for _ in pairs]

        def work(i: int, matcher: gpu_stereo.StereoMatcher = matcher, pairs: list[Pair] = pairs) -> None:
            for _ in range(5):
                found[i].append(matcher.compute(*pairs[i]).raw)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(len(pairs))]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for maps, one in zip(found, expected, strict=True):
            assert len(maps) == 5
            for other in maps:
                np.testing.assert_array_equal(other, one)


def resident() -> int:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="NOT TESTED: only Linux tells the memory in use")
@pytest.mark.parametrize("way", ["compute", "stream", "matchers"])
def test_a_thousand_frames_take_no_more_memory(small: Pair, way: str) -> None:
    """A map of 160x96 is 30 KB: one that stays of each frame would be 27 MB."""
    matcher = gpu_stereo.StereoMatcher(160, 96, "fast", 16, "cpu", confidence=True)

    def frames(count: int) -> None:
        if way == "stream":
            for matched in matcher.stream(small for _ in range(count)):
                _ = matched.disparity, matched.confidence
        for _ in range(count if way == "compute" else 0):
            _ = matcher.compute(*small).disparity
        for _ in range(count if way == "matchers" else 0):
            _ = gpu_stereo.match(*small, 16, "fast", "cpu").raw

    frames(100)
    gc.collect()
    before = resident()
    frames(900)
    gc.collect()
    grown = resident() - before
    assert grown < 6 << 20, f"{grown >> 10} KiB more"


FORKED = """
import os, signal, sys
import numpy as np
import gpu_stereo
signal.alarm(60)
left, right = np.random.default_rng(0).integers(0, 256, (2, 40, 60), dtype="uint8")
matcher = gpu_stereo.StereoMatcher(60, 40, disparities=16, device="cpu")
stream = matcher.stream([(left, right)] * 5)
expected = matcher.compute(left, right).raw
next(stream)
if child := os.fork():
    sys.exit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
for old in (lambda: matcher.compute(left, right), lambda: next(stream)):
    try:
        old()
    except gpu_stereo.InputError as error:
        assert "make one in each process" in str(error), error
    else:
        os._exit(3)
found = [gpu_stereo.match(left, right, 16, device="cpu"), *gpu_stereo.stream([(left, right)], 16, device="cpu")]
os._exit(0 if all((one.raw == expected).all() for one in found) else 4)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="NOT TESTED: there is no fork")
def test_children_of_a_fork_match_and_do_not_hang() -> None:
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", FORKED], capture_output=True, text=True, check=False)
    assert done.returncode == 0, (done.returncode, done.stderr)
