#include "server/page/page.hpp"

#include <algorithm>

namespace fracture::page {

const File* find(std::string_view path) {
  const std::span<const File> all = files();
  const auto found = std::find_if(all.begin(), all.end(), [path](const File& f) { return f.path == path; });
  return found == all.end() ? nullptr : &*found;
}

}  // namespace fracture::page
