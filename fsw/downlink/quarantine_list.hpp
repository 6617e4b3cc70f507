// A list of files that failed and are tried again later, so that they delay no other file.
#pragma once

#include <cstddef>
#include <cstdint>

#include "cfg/link_shares.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/time.hpp"

namespace ilp {

/// An entry is identified by class and id. There is no pause after its first fault, 1 s after the second, and each
/// further fault doubles the pause, up to `longest_pause_ns`. The list is only in memory: after a restart all files are
/// tried again.
template <std::size_t Capacity>
class QuarantineList {
 public:
  static constexpr TimeNs longest_pause_ns = 3600 * ns_per_s;

  void clear() { list_.clear(); }
  [[nodiscard]] bool empty() const { return list_.empty(); }
  /// Whether the entry still waits at time `now`.
  [[nodiscard]] bool rests(FileClass kind, std::int64_t id, TimeNs now) const {
    const Entry* entry = find(kind, id);
    return entry != nullptr && entry->until_ns > now;
  }
  [[nodiscard]] bool abandoned(FileClass kind, std::int64_t id) const {
    const Entry* entry = find(kind, id);
    return entry != nullptr && entry->abandoned;
  }
  /// Removes the entries whose pause is over.
  void forget_due(TimeNs now) {
    keep_if([&](const Entry& entry) { return entry.until_ns > now; });
  }
  void remove(FileClass kind, std::int64_t id) {
    keep_if([&](const Entry& entry) { return entry.kind != kind || entry.id != id; });
  }
  /// Adds a fault to an entry, which is made if necessary. If the fault `counts`, and it is the entry's `most`-th one
  /// that does, the entry is abandoned. `faults` gets the number of all its faults. Returns false if the list is full.
  bool add(FileClass kind, std::int64_t id, TimeNs now, bool counts, std::uint32_t most, std::uint32_t& faults) {
    Entry* entry = find(kind, id);
    if (entry == nullptr) {
      if (!list_.push_back({})) return false;
      entry = &list_.back();
      entry->kind = kind;
      entry->id = id;
    }
    faults = ++entry->faults;
    if (counts) ++entry->counted;
    entry->abandoned = entry->counted >= most;
    entry->until_ns = entry->abandoned ? now : now + pause_after(entry->faults);
    return true;
  }

 private:
  struct Entry {
    FileClass kind = FileClass::count;
    bool abandoned = false;
    std::uint32_t faults = 0, counted = 0;
    std::int64_t id = 0;
    TimeNs until_ns = 0;
  };

  template <typename Condition>
  void keep_if(Condition condition) {
    std::size_t kept = 0;
    for (const Entry& entry : list_) {
      if (condition(entry)) list_[kept++] = entry;
    }
    static_cast<void>(list_.resize(kept));
  }
  static TimeNs pause_after(std::uint32_t faults) {
    TimeNs pause = faults < 2 ? 0 : ns_per_s;
    for (std::uint32_t i = 2; i < faults && pause < longest_pause_ns; ++i) pause *= 2;
    return pause < longest_pause_ns ? pause : longest_pause_ns;
  }
  [[nodiscard]] const Entry* find(FileClass kind, std::int64_t id) const {
    for (const Entry& entry : list_) {
      if (entry.kind == kind && entry.id == id) return &entry;
    }
    return nullptr;
  }
  Entry* find(FileClass kind, std::int64_t id) {
    for (Entry& entry : list_) {
      if (entry.kind == kind && entry.id == id) return &entry;
    }
    return nullptr;
  }

  FixedVector<Entry, Capacity> list_;
};

}  // namespace ilp
