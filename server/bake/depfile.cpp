#include "server/bake/depfile.hpp"

#include "common/base/atomic_file.hpp"
#include "server/bake/output_folders.hpp"

namespace fracture::bake {
namespace {

/// Escapes a name as compilers do in depfiles, so that make does not interpret its special characters.
std::string escaped(const std::string& path) {
  std::string text;
  for (const char c : path) {
    if (c == ' ' || c == '#') text += '\\';
    if (c == '$') text += '$';
    text += c;
  }
  return text;
}

}  // namespace

std::string depfile_text(const BakeJob& job, const InputFile& input, const std::string& rules) {
  std::string text = escaped(job.output) + ": " + escaped(job.input);
  for (const SiblingFile& file : input.siblings) text += " \\\n  " + escaped(file.path);
  if (!rules.empty()) text += " \\\n  " + escaped(rules);
  return text + "\n";
}

bool write_depfile(const std::string& path, const BakeJob& job, const InputFile& input,
                   const std::string& rules) {
  const std::string text = depfile_text(job, input, rules);
  return make_folders_of(path) && write_atomically(path, std::as_bytes(std::span(text)));
}

}  // namespace fracture::bake
