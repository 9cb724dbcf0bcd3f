// Memory whose content nobody reads any more, given back before its owner goes.
#pragma once

#include <cstddef>

namespace fracture {

/// The system may take the whole pages of these bytes back: what they hold is lost, and reading them gives zeros or what
/// was there. The memory stays allocated. A function of performance alone: where the system offers no such thing,
/// nothing happens.
void forget_pages(void* memory, std::size_t bytes);

}  // namespace fracture
