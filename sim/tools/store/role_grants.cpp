#include "sim/tools/store/role_grants.hpp"

#include <algorithm>
#include <stdexcept>

#include "bsp/flight/stage_set.hpp"
#include "cfg/schedule.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/record_bytes.hpp"

namespace ilp::store_tool {
namespace {

using enum RecordType;

// The executive of every process: its start, its events and statistics, checkpoints, and the record of the process.
constexpr TableRights of_every_process = {
    .reads = mask_of(identity, camera, setting, command, frame, overlap, keyframe, richness, start),
    .puts = mask_of(event, component, checkpoint, timing, node),
    .erases = mask_of(checkpoint)};

// The process with the camera begins the flight.
constexpr TableRights of_the_primary = {.reads = mask_of(pose, calibration),
                                        .puts = mask_of(identity, camera, start, setting),
                                        .erases = mask_of(node, start, setting)};

void add(TableRights& to, const TableRights& rights) {
  to.reads |= rights.reads;
  to.puts |= rights.puts;
  to.erases |= rights.erases;
}

std::string quoted(const std::string& name) {
  return "\"" + name + "\"";
}

void grant(std::string& sql, const std::string& what, const std::string& table, const std::string& role) {
  sql += "GRANT " + what + " ON " + quoted(table) + " TO " + quoted(role) + ";\n";
}

void grant_table(std::string& sql, const RecordInfo& info, const TableRights& rights, const std::string& role) {
  const RecordMask bit = mask_of(info.type);
  const bool puts = (rights.puts & bit) != 0;
  const bool erases = (rights.erases & bit) != 0;
  const bool reads = puts || erases || (rights.reads & bit) != 0;
  std::string what = reads ? "SELECT" : "";
  if (puts) what += ", INSERT, UPDATE";
  const std::string of_record = what + (erases ? ", DELETE" : "");
  if (reads) grant(sql, of_record, info.name, role);
  for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
    const std::string table = std::string(info.name) + "_" + field.name;
    // A put may leave a record without its blob. Sizes of blobs are known to all, for the room that is left.
    grant(sql, reads ? what + (puts || erases ? ", DELETE" : "") : "SELECT (bytes)", table, role);
  });
}

}  // namespace

TableRights rights_of(StageMask stages) {
  TableRights rights = of_every_process;
  if ((stages & primary_stages) != 0) add(rights, of_the_primary);
  for (const Stage& stage : schedule) {
    if (!has_stage(stages, stage.component)) continue;
    add(rights, {.reads = stage.reads | stage.wakes, .puts = stage.writes | stage.changes, .erases = stage.erases});
  }
  return rights;
}

std::string role_sql(const std::string& role, StageMask stages) {
  const auto fits = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (role.empty() || role.size() > 60 || !std::all_of(role.begin(), role.end(), fits)) {
    throw std::runtime_error("\"" + role + "\" is no name for a role: use a-z, 0-9 and _, at most 60 of them");
  }
  const std::string name = quoted(role);
  std::string sql = "-- " + role + ": " + stage_names(stages).c_str() + "\n";
  sql += "DO $$BEGIN CREATE ROLE " + name + " LOGIN; EXCEPTION WHEN duplicate_object THEN NULL; END$$;\n";
  sql += "REVOKE ALL ON ALL TABLES IN SCHEMA public FROM " + name + ";\n";
  sql += "GRANT USAGE ON SCHEMA public TO " + name + ";\n";
  grant(sql, "SELECT, UPDATE", "ilp_store", role);
  const TableRights rights = rights_of(stages);
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    grant_table(sql, record_info(static_cast<RecordType>(t)), rights, role);
  }
  return sql;
}

}  // namespace ilp::store_tool
