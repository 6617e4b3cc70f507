// A part of the store: its type names the tables that its holder can access, and the compiler refuses all others.
//
//   Reader<CameraRecord>                                    may read the camera
//   StorePart<Reads<PoseRecord>, Writes<DepthRecord>>       may read poses, and make depth records
//
// A part converts to a part with fewer rights, and a Store to any part. The functions are those of store.hpp, with a
// part in place of the store. A record of another component is replaced with amend() instead of put().
#pragma once

#include "fsw/base/argument.hpp"
#include "fsw/records/record_type.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// For each kind of access, the tables that permit it.
struct StoreAccess {
  RecordMask reads = 0;
  RecordMask writes = 0;   ///< tables of the holder's own records: put()
  RecordMask changes = 0;  ///< tables in which it may replace records of another component: amend()
  RecordMask erases = 0;

  /// Tables that may be written or erased may also be read.
  [[nodiscard]] constexpr RecordMask readable() const { return reads | writes | changes | erases; }
  [[nodiscard]] constexpr RecordMask changeable() const { return writes | changes; }
  [[nodiscard]] constexpr bool covers(const StoreAccess& part) const {
    return (part.readable() & ~readable()) == 0 && (part.writes & ~writes) == 0 &&
           (part.changeable() & ~changeable()) == 0 && (part.erases & ~erases) == 0;
  }
};
[[nodiscard]] constexpr StoreAccess operator|(const StoreAccess& a, const StoreAccess& b) {
  return {a.reads | b.reads, a.writes | b.writes, a.changes | b.changes, a.erases | b.erases};
}

template <StoreAccess access>
class StoreView {
 public:
  static constexpr StoreAccess tables = access;
  template <typename Record>
  static constexpr bool may_read = (access.readable() & tables_of<Record>) != 0;
  template <typename Record>
  static constexpr bool may_write = (access.writes & tables_of<Record>) != 0;
  template <typename Record>
  static constexpr bool may_change = (access.changeable() & tables_of<Record>) != 0;
  template <typename Record>
  static constexpr bool may_erase = (access.erases & tables_of<Record>) != 0;

  // NOLINTNEXTLINE(google-explicit-constructor): whoever has the whole store may give any part of it.
  StoreView(Store& store) : store_(&store) {}
  template <StoreAccess wider>
  requires(wider.covers(access))
      // NOLINTNEXTLINE(google-explicit-constructor): a signature names what it needs.
      StoreView(const StoreView<wider>& view)
      : store_(view.store_) {}

  // NOLINTNEXTLINE(google-explicit-constructor): Transaction transaction(view).
  operator Transactions&() const { return *store_; }
  [[nodiscard]] StoreUsage usage() const { return store_->usage(); }
  [[nodiscard]] std::int64_t id_base(RecordType type) const { return store_->id_base(type); }

  template <typename Record>
  requires(may_read<Record>) Status get(std::int64_t id, Record& record)
  const { return ilp::get(*store_, id, record); }
  template <typename Record>
  requires(may_read<Record>) Status next(std::int64_t after, Record& record)
  const { return ilp::next(*store_, after, record); }
  template <typename Record>
  requires(may_read<Record>) Status last(Record& record)
  const { return ilp::last(*store_, record); }
  template <typename Record>
  requires(may_read<Record>) Status count(std::int64_t& records)
  const { return store_->count(record_info<Record>(), records); }
  template <typename Record>
  requires(may_read<Record>) Status
      read_blob(const char* field, std::int64_t id, std::size_t offset, std::span<std::uint8_t> bytes)
  const { return ilp::read_blob<Record>(*store_, field, id, offset, bytes); }
  template <typename Record>
  requires(may_write<Record>) Status put(const Record& record)
  const { return ilp::put(*store_, record); }
  /// Replaces an existing record that another component has made.
  template <typename Record>
  requires(may_change<Record>) Status amend(const Record& record)
  const { return ilp::put(*store_, record); }
  template <typename Record>
  requires(may_change<Record>) Status
      write_blob(const char* field, std::int64_t id, std::size_t offset, std::span<const std::uint8_t> bytes)
  const { return ilp::write_blob<Record>(*store_, field, id, offset, bytes); }
  template <typename Record>
  requires(may_erase<Record>) Status erase(std::int64_t id)
  const { return store_->erase(record_info<Record>(), id); }

  /// get(), next(), last() and read_blob() for a table that is chosen at run time. They return `invalid_argument` if
  /// the table is not in this part.
  Status get(const RecordInfo& info, std::int64_t id, void* record) const {
    return has(info) ? store_->get(info, id, record)
                     : out_of_range(Argument::table, static_cast<std::uint8_t>(info.type));
  }
  Status next(const RecordInfo& info, std::int64_t after, void* record) const {
    return has(info) ? store_->next(info, after, record)
                     : out_of_range(Argument::table, static_cast<std::uint8_t>(info.type));
  }
  Status last(const RecordInfo& info, void* record) const {
    return has(info) ? store_->last(info, record) : out_of_range(Argument::table, static_cast<std::uint8_t>(info.type));
  }
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) const {
    return has(info) ? store_->read_blob(info, field, id, offset, bytes)
                     : out_of_range(Argument::table, static_cast<std::uint8_t>(info.type));
  }

 private:
  template <StoreAccess>
  friend class StoreView;
  template <StoreAccess>
  friend class ValidView;

  static bool has(const RecordInfo& info) { return (access.readable() & mask_of(info.type)) != 0; }

  Store* store_;
};

// The functions of store.hpp for parts of a store.
template <StoreAccess access, typename Record>
auto get(StoreView<access> store, std::int64_t id, Record& record) -> decltype(store.get(id, record)) {
  return store.get(id, record);
}
template <StoreAccess access, typename Record>
auto next(StoreView<access> store, std::int64_t after, Record& record) -> decltype(store.next(after, record)) {
  return store.next(after, record);
}
template <StoreAccess access, typename Record>
auto last(StoreView<access> store, Record& record) -> decltype(store.last(record)) {
  return store.last(record);
}
template <StoreAccess access, typename Record>
auto put(StoreView<access> store, const Record& record) -> decltype(store.put(record)) {
  return store.put(record);
}
template <StoreAccess access, typename Record>
auto amend(StoreView<access> store, const Record& record) -> decltype(store.amend(record)) {
  return store.amend(record);
}
template <typename Record, StoreAccess access>
auto erase(StoreView<access> store, std::int64_t id) -> decltype(store.template erase<Record>(id)) {
  return store.template erase<Record>(id);
}
template <typename Record, StoreAccess access>
auto read_blob(StoreView<access> store, const char* field, std::int64_t id, std::size_t offset,
               std::span<std::uint8_t> bytes) -> decltype(store.template read_blob<Record>(field, id, offset, bytes)) {
  return store.template read_blob<Record>(field, id, offset, bytes);
}
template <typename Record, StoreAccess access>
auto write_blob(StoreView<access> store, const char* field, std::int64_t id, std::size_t offset,
                std::span<const std::uint8_t> bytes)
    -> decltype(store.template write_blob<Record>(field, id, offset, bytes)) {
  return store.template write_blob<Record>(field, id, offset, bytes);
}

// Abbreviations for signatures: StorePart<Reads<...>, Writes<...>, ...>.
template <typename... Records>
struct Reads {
  static constexpr StoreAccess access{.reads = tables_of<Records...>};
};
template <typename... Records>
struct Writes {
  static constexpr StoreAccess access{.writes = tables_of<Records...>};
};
template <typename... Records>
struct Changes {
  static constexpr StoreAccess access{.changes = tables_of<Records...>};
};
template <typename... Records>
struct Erases {
  static constexpr StoreAccess access{.erases = tables_of<Records...>};
};
template <typename... Parts>
using StorePart = StoreView<(StoreAccess{} | ... | Parts::access)>;
template <typename... Records>
using Reader = StorePart<Reads<Records...>>;

}  // namespace ilp
