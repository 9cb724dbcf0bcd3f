// The cost of a computation: processor time of all threads that worked on it.
#pragma once

namespace fracture {

/// Processor seconds of the calling thread since it began, including those that helper threads
/// (helper_threads.hpp) have spent in its loops. The difference of two calls on one thread is the cost of the
/// work in between.
double processor_seconds_of_this_thread();

}  // namespace fracture
