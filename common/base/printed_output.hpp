// Standard output of a program: either everything that was printed arrives, or the program knows that it did not.
#pragma once

namespace fracture {

/// Opens /dev/null for each standard stream that is closed, so that no other file gets its number and the text
/// meant for the stream. Reading or writing such a stream still fails (EBADF). Call it first in main().
void occupy_standard_streams();

/// Flushes what was printed through stdout and std::cout. Returns 0, or the errno of the first failure in this
/// process. Call it right after long texts: if printing failed, errno still has the reason.
int flush_printed();

/// Ends a program: flushes, and asks the file system for errors that it reports only when a file is closed. Returns
/// `exit_code`. If output was lost, prints the reason and the program's name to standard error, and returns kExitSystem.
int finish_printed(const char* program, int exit_code);

}  // namespace fracture
