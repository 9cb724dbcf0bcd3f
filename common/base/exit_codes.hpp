// The exit codes of all programs in this project. One table, so that a script need not know which program it
// ran.
#pragma once

namespace fracture {

inline constexpr int kExitDone = 0;  ///< success; `health`: healthy; `inspect`: a closed solid without repair
inline constexpr int kExitSystem =
    1;  ///< a file, standard output, port, display or server is not available; `health`: not healthy
inline constexpr int kExitUsage =
    2;  ///< the command line is wrong, or a manifest, rules or settings that it names
inline constexpr int kExitRefused = 3;        ///< the mesh or a parameter is refused
inline constexpr int kExitInternal = 4;       ///< a bug, lack of memory, or a result that fails its check
inline constexpr int kExitRepaired = 5;       ///< `inspect`: usable, but only after repair
inline constexpr int kExitInterrupted = 130;  ///< stopped by SIGINT or SIGTERM before the work was done

/// The table at the end of a command's help.
inline constexpr const char* kExitCodesInWords =
    "Exit codes of every command. 0: done (health: healthy; inspect: a closed solid without repair). 1: a file, a port or a server is "
    "not available (health: not healthy). 2: the command line, a manifest, rules or settings are wrong. 3: the mesh or a parameter is "
    "refused. 4: a bug, lack of memory, or a result that fails its check. 5: usable after repair (inspect). 130: stopped.";

}  // namespace fracture
