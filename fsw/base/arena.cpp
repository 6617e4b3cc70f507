#include "fsw/base/arena.hpp"

#include <bit>
#include <cstring>

namespace ilp {

/// The header of a block; its payload follows. A free block keeps its list links at the start of its payload.
struct alignas(Arena::alignment) Arena::Block {
  std::size_t payload_and_used;  ///< payload bytes (a multiple of 16), plus 1 while in use
  Block* before;                 ///< the neighbour at the lower address, nullptr for the first

  struct Links {
    Block* next;
    Block* previous;
  };

  [[nodiscard]] bool used() const { return (payload_and_used & 1U) != 0; }
  [[nodiscard]] std::size_t payload() const { return payload_and_used & ~std::size_t{1}; }
  [[nodiscard]] std::byte* data() { return reinterpret_cast<std::byte*>(this) + sizeof(Block); }
  [[nodiscard]] Block* after() { return reinterpret_cast<Block*>(data() + payload()); }
  [[nodiscard]] Links& links() { return *reinterpret_cast<Links*>(data()); }
};

namespace {

constexpr std::size_t header_bytes = 16;
constexpr std::size_t min_payload = 16;

constexpr std::size_t round_up(std::size_t bytes) {
  const std::size_t rounded = (bytes + Arena::alignment - 1) & ~(Arena::alignment - 1);
  return rounded < min_payload ? min_payload : rounded;
}

}  // namespace

void Arena::init(void* region, std::size_t bytes) {
  const auto address = reinterpret_cast<std::uintptr_t>(region);
  const std::size_t skip = (alignment - address % alignment) % alignment;
  bytes = bytes > skip ? bytes - skip : 0;
  bytes_ = (bytes < max_bytes ? bytes : max_bytes) & ~(alignment - 1);
  base_ = static_cast<std::byte*>(region) + skip;
  stats_ = {};
  stats_.capacity = bytes_;
  exhausted_ = false;
  reset();
}

void Arena::reset() {
  static_assert(sizeof(Block) == header_bytes && sizeof(Block::Links) <= min_payload);
  first_map_ = 0;
  for (std::uint32_t& map : second_map_) map = 0;
  for (auto& row : free_) {
    for (Block*& head : row) head = nullptr;
  }
  stats_.in_use = 0;
  if (bytes_ < 2 * header_bytes + min_payload) return;
  auto* whole = reinterpret_cast<Block*>(base_);
  whole->payload_and_used = bytes_ - 2 * header_bytes;
  whole->before = nullptr;
  // A used block without payload ends the region, so that merging needs no test for the end.
  Block* end = whole->after();
  end->payload_and_used = 1;
  end->before = whole;
  insert_free(whole);
}

Arena::SizeClass Arena::class_of(std::size_t payload) {
  const auto units = static_cast<std::uint32_t>(payload / alignment);
  if (units < second_count) return {0, units};
  const auto top = static_cast<std::uint32_t>(std::bit_width(units)) - 1;
  const std::uint32_t shift = top - second_bits;
  return {shift + 1, (units >> shift) - second_count};
}

void Arena::insert_free(Block* block) {
  const SizeClass c = class_of(block->payload());
  Block*& head = free_[c.first][c.second];
  block->links() = {head, nullptr};
  if (head != nullptr) head->links().previous = block;
  head = block;
  first_map_ |= 1U << c.first;
  second_map_[c.first] |= 1U << c.second;
}

void Arena::remove_free(Block* block) {
  const Block::Links links = block->links();
  if (links.next != nullptr) links.next->links().previous = links.previous;
  if (links.previous != nullptr) {
    links.previous->links().next = links.next;
    return;
  }
  const SizeClass c = class_of(block->payload());
  free_[c.first][c.second] = links.next;
  if (links.next != nullptr) return;
  second_map_[c.first] &= ~(1U << c.second);
  if (second_map_[c.first] == 0) first_map_ &= ~(1U << c.first);
}

Arena::Block* Arena::take_fitting(std::size_t payload) {
  if (base_ == nullptr || payload > bytes_) return nullptr;
  // The first block of the request's own class may be large enough; every block of the next class is.
  const SizeClass own = class_of(payload);
  Block* block = free_[own.first][own.second];
  if (block == nullptr || block->payload() < payload) {
    const std::uint32_t above = own.second + 1 < second_count ? second_map_[own.first] & (~0U << (own.second + 1)) : 0;
    if (above != 0) {
      block = free_[own.first][std::countr_zero(above)];
    } else {
      const std::uint32_t larger = first_map_ & (~0U << (own.first + 1));
      if (larger == 0) return nullptr;
      const int first = std::countr_zero(larger);
      block = free_[first][std::countr_zero(second_map_[first])];
    }
  }
  remove_free(block);
  return block;
}

Arena::Block* Arena::merge_with_neighbours(Block* block) {
  Block* after = block->after();
  if (!after->used()) {
    remove_free(after);
    block->payload_and_used += header_bytes + after->payload();
  }
  Block* before = block->before;
  if (before != nullptr && !before->used()) {
    remove_free(before);
    before->payload_and_used += header_bytes + block->payload();
    block = before;
  }
  block->after()->before = block;
  return block;
}

// Releases the bytes of `block` beyond `payload`. `block` is unlinked and not marked as used.
void Arena::split_tail(Block* block, std::size_t payload) {
  if (block->payload() < payload + header_bytes + min_payload) return;
  const std::size_t rest = block->payload() - payload - header_bytes;
  block->payload_and_used = payload;
  Block* tail = block->after();
  tail->payload_and_used = rest;
  tail->before = block;
  tail->after()->before = tail;
  Block* after = tail->after();
  if (!after->used()) {
    remove_free(after);
    tail->payload_and_used += header_bytes + after->payload();
    tail->after()->before = tail;
  }
  insert_free(tail);
}

void Arena::mark_used(Block* block) {
  stats_.in_use += header_bytes + block->payload();
  if (stats_.in_use > stats_.peak) stats_.peak = stats_.in_use;
  const auto end = static_cast<std::size_t>(block->data() + block->payload() - base_);
  if (end > stats_.high_water) stats_.high_water = end;
  block->payload_and_used |= 1U;
}

void* Arena::fail() {
  ++stats_.failed;
  exhausted_ = true;
  return nullptr;
}

void* Arena::allocate(std::size_t bytes) {
  ++stats_.requests;
  if (bytes > bytes_) return fail();
  const std::size_t payload = round_up(bytes);
  Block* block = take_fitting(payload);
  if (block == nullptr) return fail();
  split_tail(block, payload);
  mark_used(block);
  return block->data();
}

void* Arena::allocate_aligned(std::size_t boundary, std::size_t bytes) {
  if (boundary <= alignment) return allocate(bytes);
  ++stats_.requests;
  if (bytes > bytes_ || boundary > bytes_) return fail();
  const std::size_t payload = round_up(bytes);
  Block* block = take_fitting(payload + boundary + header_bytes + min_payload);
  if (block == nullptr) return fail();
  const auto address = reinterpret_cast<std::uintptr_t>(block->data());
  std::size_t gap = (boundary - address % boundary) % boundary;
  if (gap != 0 && gap < header_bytes + min_payload) gap += boundary;
  if (gap != 0) {
    const std::size_t rest = block->payload() - gap;
    block->payload_and_used = gap - header_bytes;
    Block* aligned = block->after();
    aligned->payload_and_used = rest;
    aligned->before = block;
    aligned->after()->before = aligned;
    insert_free(block);
    block = aligned;
  }
  split_tail(block, payload);
  mark_used(block);
  return block->data();
}

void* Arena::reallocate(void* pointer, std::size_t bytes) {
  if (pointer == nullptr) return allocate(bytes);
  Block* block = used_block(pointer);
  if (block == nullptr) {
    ++stats_.misuse;
    return nullptr;
  }
  ++stats_.requests;
  if (bytes > bytes_) return fail();
  const std::size_t payload = round_up(bytes);
  const std::size_t old_payload = block->payload();
  Block* after = block->after();
  const std::size_t reach = old_payload + (after->used() ? 0 : header_bytes + after->payload());
  if (payload <= reach) {
    stats_.in_use -= header_bytes + old_payload;
    block->payload_and_used = reach;
    if (reach != old_payload) {
      remove_free(after);
      block->after()->before = block;
    }
    split_tail(block, payload);
    mark_used(block);
    return pointer;
  }
  --stats_.requests;
  void* moved = allocate(bytes);
  if (moved == nullptr) return nullptr;
  std::memcpy(moved, pointer, old_payload < bytes ? old_payload : bytes);
  release(pointer);
  return moved;
}

void Arena::release(void* pointer) {
  if (pointer == nullptr) return;
  Block* block = used_block(pointer);
  if (block == nullptr) {
    ++stats_.misuse;
    return;
  }
  block->payload_and_used &= ~std::size_t{1};
  stats_.in_use -= header_bytes + block->payload();
  insert_free(merge_with_neighbours(block));
}

std::size_t Arena::usable_size(const void* pointer) const {
  const Block* block = used_block(pointer);
  return block == nullptr ? 0 : block->payload();
}

bool Arena::owns(const void* pointer) const {
  const auto address = reinterpret_cast<std::uintptr_t>(pointer);
  const auto base = reinterpret_cast<std::uintptr_t>(base_);
  return base_ != nullptr && address >= base && address - base < bytes_;
}

Arena::Block* Arena::used_block(const void* pointer) const {
  if (!owns(pointer) || reinterpret_cast<std::uintptr_t>(pointer) % alignment != 0) return nullptr;
  const auto offset = static_cast<std::size_t>(static_cast<const std::byte*>(pointer) - base_);
  if (offset < header_bytes) return nullptr;
  auto* block = reinterpret_cast<Block*>(base_ + offset - header_bytes);
  return block->used() ? block : nullptr;
}

}  // namespace ilp
