"""progress.py LOG: copies a ninja build's output from standard input to LOG, and reports the progress of the build.

On a terminal, one line is updated in place; otherwise a new line is printed every 20 seconds. The time left assumes that the remaining
steps take as long as the steps so far. The input must have ninja's usual status, `[120/310] Building ...`.
"""
import re
import sys
import time

STATUS = re.compile(r"\[(\d+)/(\d+)\] ")
EVERY = 20  # seconds between two lines if the output is not a terminal


def in_words(seconds):
    """Returns a duration in words: '40 seconds', '1 minute', '3 minutes'."""
    if seconds < 55:
        return f"{max(10, round(seconds, -1)):.0f} seconds"
    minutes = round(seconds / 60)
    return f"{minutes} minute{'' if minutes == 1 else 's'}"


def line_of(done, steps, elapsed):
    """Returns one line of progress. During the first steps, the line does not contain the time left, because these steps say too little
    about the rest."""
    text = f"   building {done} of {steps}"
    if elapsed >= 10 and 0 < done < steps:
        text += f", about {in_words(elapsed * (steps - done) / done)} left"
    return text


def follow(lines, log, out, clock=time.monotonic):
    began = last = clock()
    rewrites, shown = out.isatty(), False
    for line in lines:
        log.write(line)
        status = STATUS.match(line)
        now = clock()
        if not status or now - last < (0.2 if rewrites else EVERY):
            continue
        last, shown = now, True
        text = line_of(int(status[1]), int(status[2]), now - began)
        out.write(f"\r{text:<60}" if rewrites else text + "\n")
        out.flush()
    if rewrites and shown:
        out.write("\r" + " " * 60 + "\r")


if __name__ == "__main__":
    with open(sys.argv[1], "a", encoding="utf-8", errors="replace", buffering=1) as file:
        sys.stdin.reconfigure(errors="replace")
        follow(sys.stdin, file, sys.stdout)
