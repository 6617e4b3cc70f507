// Roles of a database server, one for each process of a flight, that may touch what the rows of its stages name
// (cfg/schedule.hpp) and nothing else.
#pragma once

#include <string>

#include "fsw/records/field.hpp"
#include "hal/store/store_sharing.hpp"

namespace ilp::store_tool {

struct TableRights {
  RecordMask reads = 0;
  RecordMask puts = 0;  ///< inserts and updates
  RecordMask erases = 0;
};

/// Of a process that runs these stages: its stages' rows, and what every process needs for itself.
[[nodiscard]] TableRights rights_of(StageMask stages);

/// SQL that makes the role, without a password, takes away what it may do to the tables and grants the rights. It can
/// be carried out again. Throws std::runtime_error for a name with other characters than a-z, 0-9 and _.
[[nodiscard]] std::string role_sql(const std::string& role, StageMask stages);

}  // namespace ilp::store_tool
