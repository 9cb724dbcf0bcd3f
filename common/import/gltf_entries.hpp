// Reads one text of each entry in a glTF's lists, without building a document in memory. Checks made before a
// sandbox reads the file must not need more memory than the file itself.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>

namespace fracture {

/// Returns the JSON of a GLB (glTF 2.0, section 4.4: a header of 12 bytes, then the JSON chunk as length,
/// type, text), or the whole text if it is not a GLB.
std::string_view gltf_text(std::string_view bytes);

/// Calls take(list, text) for every string `<list>[k].<member>` of the outermost object, in the order of the
/// text, until it returns false. Returns false if it did, or if the text is not JSON; earlier calls are then
/// meaningless.
bool read_gltf_entries(std::string_view bytes, const char* member,
                       const std::function<bool(const std::string& list, std::string& text)>& take);

}  // namespace fracture
