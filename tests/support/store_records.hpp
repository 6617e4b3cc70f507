// Records of a store: all of a kind at once, and changes in a transaction of their own.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

#include "hal/store/store.hpp"

namespace ilp::test {

/// In the order of their ids.
template <typename Record>
[[nodiscard]] std::vector<Record> records_of(Store& store) {
  std::vector<Record> records;
  Record record;
  for (std::int64_t id = 0; next(store, id, record).ok(); id = record.id) records.push_back(record);
  return records;
}
/// The events with this code.
[[nodiscard]] inline std::vector<EventRecord> events_of(Store& store, StatusCode code) {
  std::vector<EventRecord> events = records_of<EventRecord>(store);
  std::erase_if(events, [&](const EventRecord& event) { return event.code != static_cast<std::uint16_t>(code); });
  return events;
}

/// Calls `change` in a transaction and commits it.
template <typename Change>
void in_transaction(Store& store, const Change& change) {
  Transaction transaction(store);
  ASSERT_TRUE(transaction.begin().ok());
  change();
  ASSERT_TRUE(transaction.commit().ok());
}
/// Puts all of them in one transaction.
template <typename... Records>
void write_records(Store& store, const Records&... records) {
  const auto write = [&store](const auto& record) { EXPECT_TRUE(put(store, record).ok()); };
  in_transaction(store, [&] { (write(records), ...); });
}
/// Erases all records of these kinds in one transaction.
template <typename... Records>
void erase_records(Store& store) {
  const auto erase = [&store]<typename Record>(const std::vector<Record>& records) {
    for (const Record& record : records) EXPECT_TRUE(store.erase(record_info<Record>(), record.id).ok());
  };
  in_transaction(store, [&] { (erase(records_of<Records>(store)), ...); });
}

}  // namespace ilp::test
