// An allocator with bounded time in one fixed region, for the libraries that must allocate (SQLite, OpenJPEG).
#pragma once

#include <cstddef>
#include <cstdint>

namespace ilp {

/// Counts that become telemetry. Sizes are in bytes and include block headers.
struct ArenaStats {
  std::size_t capacity = 0;
  std::size_t in_use = 0;
  std::size_t peak = 0;        ///< largest in_use since init
  std::size_t high_water = 0;  ///< largest offset of the end of a block in use: the size that the region must have
  std::uint64_t requests = 0;
  std::uint64_t failed = 0;  ///< requests for which no free block was large enough
  std::uint64_t misuse = 0;  ///< calls with a pointer to no block in use; they change nothing
};

/// Two-level segregated fit (M. Masmano, I. Ripoll, A. Crespo, J. Real, "TLSF: a New Dynamic Memory Allocator for
/// Real-Time Systems", ECRTS 2004). Every call takes constant time, apart from the copy in reallocate. Free neighbours
/// are merged at once, so that an empty arena is one block again. Every pointer is aligned to 16 bytes. The class is
/// not thread-safe. Its initialisation is constant, so that malloc may use an arena before any constructor has run.
class Arena {
 public:
  static constexpr std::size_t alignment = 16;
  static constexpr std::size_t max_bytes = std::size_t{1} << 31U;

  constexpr Arena() = default;
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  /// Takes over `bytes` at `region` (bytes beyond max_bytes stay unused) and clears all counts.
  void init(void* region, std::size_t bytes);
  /// Releases every block at once; the counts stay.
  void reset();

  /// Returns nullptr and counts a failure when no free block is large enough. A request of 0 bytes gives a distinct
  /// pointer.
  [[nodiscard]] void* allocate(std::size_t bytes);
  /// As allocate(), with a pointer that is a multiple of `boundary`, a power of two.
  [[nodiscard]] void* allocate_aligned(std::size_t boundary, std::size_t bytes);
  /// As realloc. The block grows in place where its neighbour is free. The old block stays unchanged when the call
  /// fails.
  [[nodiscard]] void* reallocate(void* pointer, std::size_t bytes);
  void release(void* pointer);

  /// Usable bytes at `pointer`, at least as many as were requested; 0 if it points to no block in use.
  [[nodiscard]] std::size_t usable_size(const void* pointer) const;
  [[nodiscard]] bool owns(const void* pointer) const;
  [[nodiscard]] const ArenaStats& stats() const { return stats_; }

  /// Whether a request has failed since clear_exhausted().
  [[nodiscard]] bool exhausted() const { return exhausted_; }
  void clear_exhausted() { exhausted_ = false; }

 private:
  struct alignas(alignment) Block;
  struct SizeClass {
    std::uint32_t first;
    std::uint32_t second;
  };
  static constexpr std::uint32_t second_bits = 5;
  static constexpr std::uint32_t second_count = 1U << second_bits;
  static constexpr std::uint32_t first_count = 24;  // payloads below 2^32 in units of 16 bytes

  static SizeClass class_of(std::size_t payload);
  Block* take_fitting(std::size_t payload);
  void insert_free(Block* block);
  void remove_free(Block* block);
  Block* merge_with_neighbours(Block* block);
  void split_tail(Block* block, std::size_t payload);
  void mark_used(Block* block);
  void* fail();
  [[nodiscard]] Block* used_block(const void* pointer) const;

  std::byte* base_ = nullptr;
  std::size_t bytes_ = 0;
  std::uint32_t first_map_ = 0;
  std::uint32_t second_map_[first_count] = {};
  Block* free_[first_count][second_count] = {};
  ArenaStats stats_;
  bool exhausted_ = false;
};

}  // namespace ilp
