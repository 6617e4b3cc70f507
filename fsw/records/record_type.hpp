// The RecordType of a record struct, as a constant.
#pragma once

#include "fsw/records/records.hpp"

namespace ilp {

template <typename Record>
inline constexpr RecordType record_type = RecordType::count;
#define RECORD(number, record, name, ...) \
  template <>                             \
  inline constexpr RecordType record_type<record> = RecordType::name;
#include "fsw/records/records.inc"

/// The set of the tables of these records.
template <typename... Records>
inline constexpr RecordMask tables_of = (RecordMask{0} | ... | mask_of(record_type<Records>));

}  // namespace ilp
