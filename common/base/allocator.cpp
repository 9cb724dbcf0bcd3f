#include "common/base/allocator.hpp"

#include <malloc.h>

namespace fracture {

void join_small_blocks_when_freed() { ::mallopt(M_MXFAST, 0); }

}  // namespace fracture
