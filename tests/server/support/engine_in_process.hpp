// The real engine, which reads files in the test's own process.
#pragma once

#include <memory>

#include "common/import/import.hpp"
#include "server/service/engine.hpp"

namespace fracture::test {

inline std::unique_ptr<FractureEngine> engine_in_process() {
  return make_engine(
      Importer([](std::span<const std::byte> bytes, MeshFormat format, std::span<const ImportFile> files,
                  std::string_view, const ImportLimits& limits, const Execution& execution) {
        execution.poll();
        return import_mesh(bytes, format, limits, files);
      }));
}

}  // namespace fracture::test
