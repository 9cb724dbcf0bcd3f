// What a computation has cost: processor time, of all the threads that worked in it.
#pragma once

namespace fracture {

/// Processor seconds of the calling thread since it began, with those that helper threads
/// (helper_threads.hpp) have spent in its loops. Differences of two calls on one thread are what was computed
/// in between.
double processor_seconds_of_this_thread();

}  // namespace fracture
