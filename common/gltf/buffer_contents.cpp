#include "common/gltf/buffer_contents.hpp"

#include "common/base/work_blocks.hpp"

namespace fracture {

std::size_t BufferContents::size() const {
  std::size_t sum = 0;
  for (const View& view : views_) sum += aligned(view.size);
  return sum;
}

void BufferContents::write(std::uint8_t* buffer, const Execution& execution) const {
  std::vector<std::uint8_t*> begin;
  for (const View& view : views_) {
    begin.push_back(buffer);
    buffer += aligned(view.size);
  }
  constexpr std::uint64_t kBlock = std::uint64_t{1} << 18;  // bytes per block: enough to be worth a thread
  const WorkBlocks blocks(execution, pieces_.size(), kBlock,
                          [this](std::size_t k) { return pieces_[k].bytes + 64; });
  parallel_for_blocks(execution, blocks, [&](std::size_t, std::size_t first, std::size_t last) {
    Pacer pacer(execution);
    for (std::size_t k = first; k < last; ++k) {
      const Piece& piece = pieces_[k];
      pacer.step();
      piece.write(piece.source, {begin[piece.view] + piece.at, piece.bytes}, pacer);
    }
  });
}

}  // namespace fracture
