// Squares of a plane that are made once and kept while they are in use: the least recently used go first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

namespace ilp::world {

struct TileAddress {
  std::int32_t i = 0, j = 0;
  bool operator==(const TileAddress&) const = default;
  auto operator<=>(const TileAddress&) const = default;
};

/// Safe to use from several threads: two that want the same tile wait for one that makes it.
template <typename Tile>
class TileCache {
 public:
  explicit TileCache(std::size_t capacity) : capacity_(capacity) {}

  /// The tile, made by `make(address)` if it is not there. Stays valid as long as it is held.
  template <typename Make>
  [[nodiscard]] std::shared_ptr<const Tile> get(TileAddress address, Make make) {
    const std::shared_ptr<Slot> slot = find(address);
    std::call_once(slot->once, [&] { slot->tile = make(address); });
    return {slot, &slot->tile};
  }

 private:
  struct Slot {
    std::once_flag once;
    Tile tile;
  };
  struct Entry {
    std::shared_ptr<Slot> slot;
    typename std::list<TileAddress>::iterator age;
  };

  std::shared_ptr<Slot> find(TileAddress address) {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(address);
    if (found != entries_.end()) {
      ages_.splice(ages_.begin(), ages_, found->second.age);
      return found->second.slot;
    }
    if (entries_.size() >= capacity_) {
      entries_.erase(ages_.back());
      ages_.pop_back();
    }
    ages_.push_front(address);
    auto slot = std::make_shared<Slot>();
    entries_.emplace(address, Entry{slot, ages_.begin()});
    return slot;
  }

  std::size_t capacity_;
  std::mutex mutex_;
  std::list<TileAddress> ages_;  // the youngest first
  std::map<TileAddress, Entry> entries_;
};

}  // namespace ilp::world
