// One text of each entry of a glTF's lists, without a document in memory: what is asked before a sandbox reads the file may cost
// no more than the file.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>

namespace fracture {

/// The JSON of a GLB (glTF 2.0, section 4.4: 12 bytes of header, then the JSON chunk as length, type, text), or the text itself.
std::string_view gltf_text(std::string_view bytes);

/// Calls take(list, text) for every string `<list>[k].<member>` of the outermost object, in the order of the text, until it
/// returns false. False: it did, or the text is no JSON; what was taken before is then worth nothing.
bool read_gltf_entries(std::string_view bytes, const char* member,
                       const std::function<bool(const std::string& list, std::string& text)>& take);

}  // namespace fracture
