// A store in front of another one whose calls fail as a test requests.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <utility>

#include "hal/store/forwarding_store.hpp"

namespace ilp::test {

enum class StoreCall : std::uint8_t {
  begin,
  commit,
  put,
  get,
  next,
  last,
  erase,
  count,
  write_blob,
  read_blob,
  poll,
  kinds
};

[[nodiscard]] constexpr const char* store_call_name(StoreCall call) {
  constexpr const char* names[] = {"begin", "commit", "put",        "get",       "next", "last",
                                   "erase", "count",  "write_blob", "read_blob", "poll"};
  static_assert(sizeof(names) / sizeof(names[0]) == static_cast<std::size_t>(StoreCall::kinds));
  return names[static_cast<std::size_t>(call)];
}

/// Failures follow the contract of Store: a failed call does nothing, a failed write dooms its transaction, and a
/// failed commit rolls back.
class FailingStore final : public ForwardingStore {
 public:
  struct Call {
    StoreCall kind = StoreCall::begin;
    RecordType type = RecordType::count;  ///< table of the call; `count`: none
    std::int64_t id = 0;                  ///< id of the record; 0: the call names none
    std::int64_t number = 0;              ///< number of the call among all that can fail, from 0
  };
  /// Called before every call that can fail. A status other than ok is returned without calling the inner store.
  using Judge = std::function<Status(const Call&)>;

  explicit FailingStore(Store& store, Judge judge = {}) : ForwardingStore(store), judge_(std::move(judge)) {}

  void judge_by(Judge judge) { judge_ = std::move(judge); }
  /// Lets `calls` calls from number `first` on return `fault`. Replaces the judge.
  void fail(std::int64_t first, std::int64_t calls = 1, const Status& fault = {StatusCode::store_error, 10}) {
    judge_ = [=](const Call& call) { return call.number >= first && call.number < first + calls ? fault : Status{}; };
  }
  /// Behaves as if another process kept the writers' lock, until recover().
  void lock() {
    judge_ = [](const Call& call) {
      return call.kind == StoreCall::begin ? Status{StatusCode::store_locked} : Status{};
    };
  }
  void recover() { judge_ = {}; }
  /// Makes a record read as damaged until it is put or erased; with `blobs`, its blobs too.
  void damage(RecordType type, std::int64_t id, bool blobs = true) { damaged_[{type, id}] = blobs; }
  /// Number of calls that could fail, and of those that the judge has let fail.
  [[nodiscard]] std::int64_t calls() const { return calls_; }
  [[nodiscard]] std::int64_t failed() const { return failed_; }

  Status begin() override {
    ILP_TRY(admit(StoreCall::begin));
    doomed_ = {};
    return inner_.begin();
  }
  Status commit() override {
    Status status = admit(StoreCall::commit);
    if (status.ok()) status = doomed_;
    if (status.ok()) return inner_.commit();
    rollback();
    return status;
  }
  void rollback() override {
    doomed_ = {};
    inner_.rollback();
  }
  Status put(const RecordInfo& info, const void* record) override {
    ILP_TRY(admit_write(StoreCall::put, info, id_of(record)));
    damaged_.erase({info.type, id_of(record)});
    return inner_.put(info, record);
  }
  Status get(const RecordInfo& info, std::int64_t id, void* record) override {
    ILP_TRY(admit(StoreCall::get, info.type, id));
    if (is_damaged(info, id)) return damage_of(info, id);
    return inner_.get(info, id, record);
  }
  Status next(const RecordInfo& info, std::int64_t after, void* record) override {
    ILP_TRY(admit(StoreCall::next, info.type));
    for (const auto& [row, blobs] : damaged_) {
      if (row.first != info.type || row.second <= after) continue;
      const Status status = inner_.next(info, after, record);
      const bool before = status.ok() && id_of(record) < row.second;
      return before ? status : damage_of(info, row.second);
    }
    return inner_.next(info, after, record);
  }
  Status last(const RecordInfo& info, void* record) override {
    ILP_TRY(admit(StoreCall::last, info.type));
    const Status status = inner_.last(info, record);
    return status.ok() && is_damaged(info, id_of(record)) ? damage_of(info, id_of(record)) : status;
  }
  Status erase(const RecordInfo& info, std::int64_t id) override {
    ILP_TRY(admit_write(StoreCall::erase, info, id));
    damaged_.erase({info.type, id});
    return inner_.erase(info, id);
  }
  Status count(const RecordInfo& info, std::int64_t& records) override {
    ILP_TRY(admit(StoreCall::count, info.type));
    return inner_.count(info, records);
  }
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override {
    ILP_TRY(admit_write(StoreCall::write_blob, info, id));
    return inner_.write_blob(info, field, id, offset, bytes);
  }
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override {
    ILP_TRY(admit(StoreCall::read_blob, info.type, id));
    const auto hit = damaged_.find({info.type, id});
    if (hit != damaged_.end() && hit->second) return damage_of(info, id);
    return inner_.read_blob(info, field, id, offset, bytes);
  }
  Status poll(RecordMask& changed) override {
    ILP_TRY(admit(StoreCall::poll));
    return inner_.poll(changed);
  }

 private:
  [[nodiscard]] bool is_damaged(const RecordInfo& info, std::int64_t id) const {
    return damaged_.count({info.type, id}) != 0;
  }
  static Status damage_of(const RecordInfo& info, std::int64_t id) {
    return {StatusCode::record_damaged, id, static_cast<std::int64_t>(info.type)};
  }
  static std::int64_t id_of(const void* record) { return *static_cast<const std::int64_t*>(record); }

  Status admit(StoreCall kind, RecordType type = RecordType::count, std::int64_t id = 0) {
    const Call call{kind, type, id, calls_++};
    if (!judge_) return {};
    const Status status = judge_(call);
    failed_ += status.ok() ? 0 : 1;
    return status;
  }
  Status admit_write(StoreCall kind, const RecordInfo& info, std::int64_t id) {
    const Status status = admit(kind, info.type, id);
    if (!status.ok() && doomed_.ok()) doomed_ = status;
    return doomed_;
  }

  Judge judge_;
  Status doomed_;
  std::map<std::pair<RecordType, std::int64_t>, bool> damaged_;
  std::int64_t calls_ = 0;
  std::int64_t failed_ = 0;
};

}  // namespace ilp::test
