#include "server/bake/sentences.hpp"

#include <cstdio>

#include "common/base/printable.hpp"
#include "common/base/stage.hpp"
#include "server/bake/output_path.hpp"

namespace fracture::bake {

std::string name_of_input(const std::string& path) {
  return path == kStandardStream ? "standard input" : printable(path);
}

std::string cannot_write(const std::string& path) {
  return (path == kStandardStream ? "cannot write to " : "cannot write ") + name_of_output(path);
}

std::string name_of_output(const std::string& path) {
  return path == kStandardStream ? "standard output" : printable(path);
}

std::string sentence_of(std::span<const WrittenFile> written, const Baked& baked, double seconds) {
  const Certificate& c = baked.summary.certificate;
  char text[300];
  std::snprintf(
      text, sizeof text,
      ": %u %s, input volume %.9g m³, output volume %.9g m³, relative error %.2g, %llu open edges, %llu bytes",
      c.fragments, c.fragments == 1 ? "fragment" : "fragments", c.volume_in, c.volume_out, c.relative_error,
      static_cast<unsigned long long>(c.open_edges), static_cast<unsigned long long>(written.front().bytes));
  std::string sentence = name_of_output(written.front().path) + text;
  if (const std::size_t beside = written.size() - 1; beside > 0)
    sentence += ", and " + std::to_string(beside) + (beside > 1 ? " more files" : " more file");
  std::snprintf(text, sizeof text, ", %.3f s", seconds);
  sentence += text;
  const char* separator = " (";
  for (const StageRow& row : kStages) {
    if (!baked.timings.ran(row.stage)) continue;
    std::snprintf(text, sizeof text, "%s%s %.1f ms", separator, row.name,
                  baked.timings.milliseconds(row.stage));
    sentence += text;
    separator = ", ";
  }
  return sentence + (baked.timings.empty() ? "" : ")");
}

}  // namespace fracture::bake
