#include "fsw/executive/flight_health.hpp"

#include <algorithm>

#include "fsw/base/result.hpp"
#include "fsw/base/text.hpp"
#include "fsw/executive/frame_timing.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

/// A fault in the executive's own use of the store.
void report_own(ComponentTable& table, const Status& status) {
  if (!status.ok() && !status.is(StatusCode::store_locked)) table.report(status);
}

Status write_timing(ComponentTable& table) {
  Transaction transaction(table.store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(table.store, table.own.timing));
  return transaction.commit();
}

Status take_up_level(ComponentTable& table) {
  TimingRecord before;
  const Status found = table.leads() ? get(table.store, table.own.timing.id, before) : Status{StatusCode::not_found};
  if (found.is(StatusCode::not_found)) return {};
  ILP_TRY(found);
  if (table.setup.real_time) table.own.work_level.restore(before.degraded);
  table.own.timing.degraded = table.own.work_level.level();
  return table.own.timing.degraded == before.degraded ? Status{} : write_timing(table);
}

Result<Backlog> measure_backlog(const ComponentTable& table) {
  std::int64_t frame = 0, looked_at = 0, keyframe = 0, rated = 0;
  ILP_TRY(newest_id<FrameRecord>(table.store, frame));
  ILP_TRY(newest_id<OverlapRecord>(table.store, looked_at));
  ILP_TRY(newest_id<KeyframeRecord>(table.store, keyframe));
  ILP_TRY(newest_id<RichnessRecord>(table.store, rated));
  // Of the keyframes this many wait for their final poses in any case.
  return Backlog{frame - looked_at, keyframe - rated - window_length(*table.setup.parameters)};
}

void judge_load(ComponentTable& table, TimeNs now) {
  const std::uint8_t before = table.own.work_level.level();
  const Result<Backlog> backlog = measure_backlog(table);
  report_own(table, backlog.status());
  const LoadReason reason = table.own.work_level.judge(table.own.window, now, backlog.value(), *table.setup.parameters);
  table.own.window = {.begin_ns = now};
  const std::uint8_t level = table.own.work_level.level();
  if (level == before) return;
  table.own.timing.degraded = level;
  ++table.own.timing.degraded_changes;
  report_own(table, write_timing(table));
  table.events.report(now, "executive",
                      level > before ? Status{StatusCode::work_reduced, level, static_cast<std::int64_t>(reason)}
                                     : Status{StatusCode::work_restored, level});
}

void count_load(ComponentTable& table, TimeNs now, TimeNs over) {
  if (table.own.window.begin_ns == 0) table.own.window.begin_ns = now;
  // The work of other processes shows in the backlog only.
  bool busy = table.setup.shares_flight;
  // Time-driven components always have work.
  for (std::size_t i = 0; i < table.stages.size(); ++i) {
    busy = busy || (table.stages[i].period == 0 && table.has_work(i));
  }
  ++table.own.window.frames;
  table.own.window.busy_frames += busy ? 1 : 0;
  table.own.window.overrun_ns += std::max<TimeNs>(over, 0);
  if (now - table.own.window.begin_ns >= ns_from_seconds(table.setup.parameters->load_window_s)) judge_load(table, now);
}

}  // namespace

/// Every component starts from its checkpoint now, so earlier commands to restart are carried out.
Status take_up(ComponentTable& table) {
  ILP_TRY(newest_id<CommandRecord>(table.store, table.own.obeyed_command_id));
  ILP_TRY(take_up_level(table));
  table.own.taken_up = true;
  return {};
}

void end_frame(ComponentTable& table, TimeNs nominal, TimeNs begin) {
  const TimeNs now = table.clock.now();
  const TimeNs over = now - (nominal + minor_frame_ns);
  count_frame(begin - nominal, now - begin, over > 0, table.own.timing);
  const Status reported = table.own.overruns.note(table.own.frame, over, now);
  if (!reported.ok()) table.events.report(now, "executive", reported);
  ++table.own.frame;
  if (!table.setup.real_time) return;
  if (table.leads()) count_load(table, now, over);
  if (table.setup.parameters->housekeeping_period_s <= 0) return;
  if (now - table.own.housekeeping_ns < ns_from_seconds(table.setup.parameters->housekeeping_period_s)) return;
  table.own.housekeeping_ns = now;
  report_own(table, write_housekeeping(table));
}

Status write_housekeeping(ComponentTable& table) {
  Transaction transaction(table.store);
  ILP_TRY(transaction.begin());
  for (std::size_t i = 0; i < table.stages.size(); ++i) {
    const ComponentStats& stats = table.slot(i).stats;
    ComponentRecord record;
    record.id = table.number_of(i);
    copy_text(record.name, table.stages[i].name);
    record.steps = stats.steps;
    record.overruns = stats.overruns;
    record.restarts = stats.restarts;
    record.faults = stats.faults;
    record.busy_ns = stats.busy_ns;
    record.longest_ns = stats.longest_ns;
    ILP_TRY(put(table.store, record));
  }
  ILP_TRY(put(table.store, table.own.timing));
  return transaction.commit();
}

}  // namespace ilp
