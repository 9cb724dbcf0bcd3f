// An array whose copies share unchanged blocks. Copying costs one pointer per block, and changing an element
// copies its block (path copying of Driscoll et al. 1989, "Making data structures persistent", on a tree of
// two levels).
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

namespace fracture {

/// Blocks are immutable once an Edit has ended. So arrays that share blocks may be read and copied by any
/// number of threads.
template <class T, std::size_t kBlock = 64>
class SharedBlocks {
 public:
  SharedBlocks() = default;
  /// Takes ownership of the array. Trivially destructible elements are not moved, and the array is freed when
  /// its last block is released. Other elements are moved into blocks, which are freed separately.
  explicit SharedBlocks(std::vector<T> all) : size_(all.size()) {
    if constexpr (!std::is_trivially_destructible_v<T>) {
      for (std::size_t k = 0; k < size_; k += kBlock) {
        blocks_.push_back(std::make_shared<T[]>(kBlock));
        std::move(all.begin() + static_cast<std::ptrdiff_t>(k),
                  all.begin() + static_cast<std::ptrdiff_t>(std::min(size_, k + kBlock)),
                  blocks_.back().get());
      }
      return;
    }
    const auto owner = std::make_shared<std::vector<T>>(std::move(all));
    blocks_.reserve((size_ + kBlock - 1) / kBlock);
    for (std::size_t k = 0; k < size_; k += kBlock)
      blocks_.push_back(std::shared_ptr<T[]>(owner, owner->data() + k));
  }

  std::size_t size() const { return size_; }
  const T& operator[](std::size_t k) const { return blocks_[k / kBlock][k % kBlock]; }

  /// Changes elements of one array. While it exists, nothing else may use that array; its copies may be used.
  class Edit {
   public:
    explicit Edit(SharedBlocks& of) : of_(of), own_(of.blocks_.size(), 0) {}
    Edit(const Edit&) = delete;
    Edit& operator=(const Edit&) = delete;

    const T& operator[](std::size_t k) const { return of_[k]; }
    /// A writable reference to the element.
    T& at(std::size_t k) {
      own(k / kBlock);
      return of_.blocks_[k / kBlock][k % kBlock];
    }
    void push_back(T value) {
      const std::size_t k = of_.size_;
      if (k % kBlock == 0) {
        of_.blocks_.push_back(std::make_shared<T[]>(kBlock));
        own_.push_back(1);
      }
      own(k / kBlock);
      ++of_.size_;
      of_.blocks_[k / kBlock][k % kBlock] = std::move(value);
    }

   private:
    void own(std::size_t block) {
      if (own_[block]) return;
      const T* const from = of_.blocks_[block].get();
      auto copy = std::make_shared<T[]>(kBlock);
      std::copy_n(from, std::min(kBlock, of_.size_ - block * kBlock), copy.get());
      of_.blocks_[block] = std::move(copy);
      own_[block] = 1;
    }

    SharedBlocks& of_;
    std::vector<char> own_;  // per block: whether this edit created it
  };

 private:
  std::size_t size_ = 0;
  std::vector<std::shared_ptr<T[]>> blocks_;
};

}  // namespace fracture
