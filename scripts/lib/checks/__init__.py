"""The checks of scripts/check. Each takes a Checkout and returns offences, one line each, as `file:line: message`."""
