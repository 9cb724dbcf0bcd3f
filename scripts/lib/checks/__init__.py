"""The checks of scripts/check. Each takes a Checkout and returns its offences, one line each: `file:line: what`."""
