// The table of a record, as a constant of its type.
#pragma once

#include "fsw/records/records.hpp"

namespace ilp {

template <typename Record>
inline constexpr RecordType record_type = RecordType::count;
#define RECORD(number, record, name, ...) \
  template <>                             \
  inline constexpr RecordType record_type<record> = RecordType::name;
#include "fsw/records/records.inc"

/// The set of tables of some records.
template <typename... Records>
inline constexpr RecordMask tables_of = (RecordMask{0} | ... | mask_of(record_type<Records>));

}  // namespace ilp
