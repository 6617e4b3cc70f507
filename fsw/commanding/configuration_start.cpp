// The part of Configuration that runs at the start of a process: reads the store and the nonvolatile memory.
#include <algorithm>

#include "fsw/commanding/configuration.hpp"
#include "fsw/commanding/settings.hpp"
#include "fsw/records/store_epoch_ids.hpp"
#include "fsw/shared/find.hpp"

namespace ilp {
namespace {

/// File names and telecommands have room for the numbers of this many store epochs.
constexpr std::int64_t most_store_epochs = 50;
/// If the previous store epoch is not known, numbers begin after those of all store epochs, at an offset from the
/// calendar: it assumes less than one keyframe per second, and less than a thousand other records.
constexpr std::int64_t calendar_base = ids_per_store_epoch * most_store_epochs;
constexpr std::int64_t calendar_begin_s = 2'145'916'800;  // 2026-01-01
/// Mission time ends there. Names of files have room for keyframes of ten digits, which a thousand store epochs leave
/// free.
constexpr std::int64_t most_since_s = longest_duration_ns / ns_per_s;
/// A calendar clock that stands or goes back brings no number again: a store epoch begins so far behind the one before.
constexpr std::int64_t least_of_a_store_epoch = 1'000'000;
constexpr std::int64_t records_per_keyframe = 1000;
constexpr std::int64_t transactions_per_s = 1024;
constexpr std::int64_t calendar_transactions = std::int64_t{1} << 32U;

/// The third start in a row without a confirmation takes the last good configuration, later ones built-in parameters.
constexpr std::uint32_t start_of_last_good = 3;

Status write_alone(Store& store, const IdentityRecord& identity) {
  Transaction transaction(store);
  ILP_TRY(transaction.begin());
  ILP_TRY(put(store, identity));
  return transaction.commit();
}

Status take_settings(Store& store, const IdentityRecord& identity, FlightMemoryContent& after, bool lost) {
  // The store is ahead when a telecommand was interrupted between the two writes, or when the nonvolatile memory was
  // lost.
  if (identity.configuration <= after.configuration) return {};
  after.wanted = {};
  SettingRecord setting;
  // Bounded by the number of settings. A damaged one is left out and lost.
  for (;;) {
    ILP_TAKE(const Found found, find_next(store, setting.id, setting));
    if (found == Found::nothing) break;
    if (found == Found::damaged) continue;
    const bool epoch = static_cast<std::uint64_t>(setting.id) == epoch_number();
    if (epoch && (lost || after.epoch_known == 0 || setting.value == after.mission_epoch_s)) continue;
    static_cast<void>(after.wanted.set(static_cast<std::uint64_t>(setting.id), setting.value));
  }
  // It is not known what was confirmed. All settings count as good, because the flight has flown with them.
  if (lost) after.good = after.wanted;
  after.configuration = identity.configuration;
  return {};
}

}  // namespace

Status Configuration::begin(Store& store, const ConfigurationStart& start) {
  const Use use(*this);
  store_ = &store;
  own_ = {};
  own_.base = mission_;
  own_.most_storage_mib = start.store.is(StatusCode::store_in_memory) ? mission_.storage_budget_mib : 0;
  own_.commanded = start.commanded;
  updates_.clear();
  if (!start.loaded.ok() && !start.loaded.is(StatusCode::not_found)) {
    report({StatusCode::memory_lost, static_cast<std::int64_t>(start.loaded.code), start.loaded.a});
  }
  FlightMemoryContent after = memory_.content();
  ILP_TAKE(const bool lost, find_identity(start, after));
  // The flight keeps the epoch that it began with, whatever the mission file says: a setting of it is tentative.
  if (after.epoch_known != 0) own_.base.mission_epoch_s = after.mission_epoch_s;
  ILP_TRY(take_settings(store, own_.identity, after, lost));
  own_.unconfirmed = after.starts_unconfirmed;
  if (own_.commanded) ++after.starts_unconfirmed;
  own_.tentative_ns = after.tentative_ns;
  keep(after);
  const std::uint32_t number = own_.commanded ? own_.unconfirmed + 1 : 1;
  check_tentative();
  if (number == start_of_last_good && own_.trials > 0) revert(RevertReason::many_starts);
  enter(number < start_of_last_good    ? ConfigurationStage::as_set
        : number == start_of_last_good ? ConfigurationStage::last_good
                                       : ConfigurationStage::built_in);
  // The settings come from the nonvolatile memory. The store's records of them are only for the ground.
  static_cast<void>(write_settings());
  return {};
}

Result<bool> Configuration::find_identity(const ConfigurationStart& start, FlightMemoryContent& after) {
  Status found = get(*store_, 1, own_.identity);
  if (!found.ok() && !is_gone(found)) return found;
  const bool lost = after.configuration == 0 && (!found.ok() || after.life < own_.identity.life);
  if (found.is(StatusCode::not_found)) {
    ILP_TRY(begin_store_epoch(start));
    after = memory_.content();
  } else if (found.ok()) {
    // A store epoch that was numbered by the calendar, because the nonvolatile memory could not be read, may have a low
    // number.
    if (after.life < own_.identity.life || after.keyframe_base < own_.identity.keyframe_base) {
      after.life = std::max(after.life, own_.identity.life);
      after.keyframe_base = own_.identity.keyframe_base;
      after.record_base = own_.identity.record_base;
    }
  } else {
    // It is damaged: the nonvolatile memory knows it, or else the keyframes themselves.
    own_.identity = {};
    own_.identity.life = after.life;
    own_.identity.keyframe_base = after.keyframe_base;
    own_.identity.record_base = after.record_base;
    KeyframeRecord newest;
    if (after.life == 0 && last(*store_, newest).ok()) {
      own_.identity.keyframe_base = own_.identity.record_base = newest.id - newest.id % ids_per_store_epoch;
      own_.identity.life = own_.identity.keyframe_base / ids_per_store_epoch + 1;
    }
    ILP_TRY(write_alone(*store_, own_.identity));
  }
  store_->number_from(own_.identity.keyframe_base, own_.identity.record_base);
  return lost;
}

Status Configuration::begin_store_epoch(const ConfigurationStart& start) {
  FlightMemoryContent after = memory_.content();
  const bool known = start.loaded.ok() || (start.loaded.is(StatusCode::not_found) && start.store.ok());
  const std::int64_t before = after.keyframe_base;
  own_.identity = {};
  // What can be kept is tried first. The store epoch itself is kept only after its identity is in the store, so that a
  // start that fails in between counts none.
  keep(after);
  own_.identity.life = ++after.life;
  const std::int64_t begin = (after.life - 1) * ids_per_store_epoch;
  const std::int64_t numbers_before = after.life > 1 ? ids_per_store_epoch : 0;
  after.keyframe_base = std::max(begin, after.keyframe_base + numbers_before);
  after.record_base = std::max(begin, after.record_base + numbers_before);
  // A first store epoch needs no memory of it. If the content could not be kept, numbers begin where the next start
  // will not.
  const bool kept = memory_.kept().ok() || (known && after.life == 1 && start.store.ok());
  if ((!known || !kept || after.life > most_store_epochs) && start.utc_s > 0) {
    const std::int64_t since_s = std::clamp<std::int64_t>(start.utc_s - calendar_begin_s, 0, most_since_s);
    after.keyframe_base = std::max(calendar_base + since_s, before + least_of_a_store_epoch);
    after.record_base = after.keyframe_base * records_per_keyframe;
    memory_.skip_transactions(calendar_transactions + since_s * transactions_per_s);
  }
  own_.identity.keyframe_base = after.keyframe_base;
  own_.identity.record_base = after.record_base;
  own_.identity.configuration = after.configuration;
  ILP_TRY(write_alone(*store_, own_.identity));
  keep(after);
  if (own_.identity.keyframe_base > 0)
    report({StatusCode::life_begun, own_.identity.life, own_.identity.keyframe_base + 1});
  return {};
}

Status Configuration::write_settings() {
  const FlightMemoryContent& content = memory_.content();
  KeptSettings rows = content.wanted;
  const std::uint64_t epoch = epoch_number();
  if (rows.find(epoch) == nullptr && content.epoch_known != 0)
    static_cast<void>(rows.set(epoch, content.mission_epoch_s));
  Transaction transaction(*store_);
  bool begun = false;
  const auto open = [&]() -> Status {
    if (begun) return {};
    begun = true;
    return transaction.begin();
  };
  SettingRecord setting;
  for (;;) {  // bound: the settings; each turn reads a later one
    ILP_TAKE(const Found found, find_next(*store_, setting.id, setting));
    if (found == Found::nothing) break;
    const auto number = static_cast<std::uint64_t>(setting.id);
    const KeptSetting* const row = rows.find(number);
    if (row != nullptr && found == Found::valid && row->value == setting.value) {
      rows.remove(number);
    } else if (row == nullptr && number != epoch) {
      ILP_TRY(open());
      ILP_TRY(store_->erase(record_info<SettingRecord>(), setting.id));
    }
  }
  for (std::size_t i = 0; i < rows.count; ++i) {
    const std::size_t index = find_parameter(rows.items[i].number);
    if (index == parameter_count()) continue;
    ILP_TRY(open());
    ILP_TRY(write_setting(*store_, index, rows.items[i].value, 0));
  }
  if (!begun && own_.identity.configuration == content.configuration) return {};
  ILP_TRY(open());
  IdentityRecord after = own_.identity;
  after.configuration = content.configuration;
  ILP_TRY(put(*store_, after));
  ILP_TRY(transaction.commit());
  own_.identity = after;
  return {};
}

}  // namespace ilp
