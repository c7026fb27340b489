"""Rates and distortions: what is best within a number of bytes, and how to find it."""

import math


def psnr_db(l2):
    """Decibels of a two-sided L2 error that is a fraction of the diagonal; infinite where there is none."""
    return math.inf if l2 == 0 else -20 * math.log10(l2)


def l2_of(report):
    """The larger L2 of both directions, as `remaps measure --json` prints them; ValueError if it is no number."""
    l2 = max(float(report["l2_forward"]), float(report["l2_backward"]))
    if not (math.isfinite(l2) and l2 >= 0):
        raise ValueError(f"an L2 error of {l2}")
    return l2


def best_within(points, size):
    """The point, a dictionary with bytes and psnr, of the highest PSNR in at most so many bytes; or None."""
    fitting = [point for point in points if point["bytes"] <= size]
    return max(fitting, key=lambda point: (point["psnr"], -point["bytes"]), default=None)


def upper_envelope(points):
    """The points that no other one beats in at most as many bytes, by ascending bytes: PSNR only rises."""
    envelope = []
    for point in sorted(points, key=lambda point: (point["bytes"], -point["psnr"])):
        if not envelope or point["psnr"] > envelope[-1]["psnr"]:
            envelope.append(point)
    return envelope


def largest_fall(points):
    """The most decibels that are lost from a point to one of more bytes; 0 if PSNR only rises."""
    highest, fall = -math.inf, 0.0
    for point in sorted(points, key=lambda point: point["bytes"]):
        fall = max(fall, highest - point["psnr"])
        highest = max(highest, point["psnr"])
    return fall


def most_faces_within(bytes_of, size, most, guess, *, waste=0.01, tries=8):
    """Nearly the most faces, at most `most`, whose code takes at most `size` bytes; None if none was found.

    bytes_of  what so many faces take; about proportional to them
    waste     it is enough to leave this part of the bytes unused
    """
    low, high, faces = 0, most + 1, max(1, min(most, round(guess)))
    for _ in range(tries):
        taken = bytes_of(faces)
        if taken <= size:
            low = max(low, faces)
            if taken >= (1 - waste) * size:
                break
        else:
            high = min(high, faces)
        if high - low <= 1:
            break
        wanted = round(faces * (1 - waste / 2) * size / taken)
        faces = max(low + 1, min(high - 1, wanted))
    return low or None


def climb(value_of, start, lowest, highest):
    """The integer of the highest value among those that have one; both its neighbours were tried.

    value_of  of an integer; None where there is none. It is asked once for each. Rises to one peak, then falls.
    """
    values = {}

    def worth(i):
        if not lowest <= i <= highest:
            return -math.inf
        if i not in values:
            values[i] = value_of(i)
        return -math.inf if values[i] is None else values[i]

    at = start
    while worth(at) == -math.inf and at > lowest:  # too fine for the bytes: coarser ones may do
        at -= 1
    while True:
        best = max((at, at - 1, at + 1), key=worth)
        if best == at:
            return at if worth(at) > -math.inf else None
        at = best
