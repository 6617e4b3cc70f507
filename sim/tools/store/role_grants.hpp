// Makes roles of a database server for the processes of a flight. A role has the rights that the stages of its process
// need (cfg/schedule.hpp), and no others.
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

/// Rights of a process that runs these stages: those of the stages, and those that every process needs.
[[nodiscard]] TableRights rights_of(StageMask stages);

/// SQL that creates the role without a password, revokes its rights to all tables and grants those of `rights_of`. It
/// can be run repeatedly. Throws std::runtime_error unless the name has 1 to 60 characters of a-z, 0-9 and _.
[[nodiscard]] std::string role_sql(const std::string& role, StageMask stages);

}  // namespace ilp::store_tool
