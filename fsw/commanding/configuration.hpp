// The parameters in force: those of the mission file, replaced by settings from telecommands. Settings under which the
// ground cannot reach the flight are reverted (docs/getting-back-in.md).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/checksum.hpp"
#include "fsw/base/enumeration.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/result.hpp"
#include "fsw/shared/flight_memory.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// The first value of the event configuration_reverted.
ILP_ENUMERATION(RevertReason, (1, start_failed, "the flight could not start with them"),
                (2, not_confirmed, "no telecommand came for [contact] trial_s of contact"),
                (3, many_starts, "it was the third start in a row without a telecommand"))

/// What is known before a start.
struct ConfigurationStart {
  Status loaded;           ///< result of FlightMemory::load
  std::int64_t utc_s = 0;  ///< the calendar, seconds since 1958; 0: none
  bool commanded = false;  ///< there is a link for telecommands, so that the ground can confirm
  /// Why the store replaces another one; ok: it does not. With `store_in_memory` it holds no more than the budget of
  /// the parameters that begin() finds.
  Status store = {};
};

/// Lasting state. Its checksum is kept, so that a flipped bit is detected before it acts.
struct ConfigurationState {
  MissionParameters base;    ///< of the mission file
  MissionParameters good;    ///< with confirmed settings
  MissionParameters wanted;  ///< with all settings
  IdentityRecord identity;
  double most_storage_mib = 0;
  std::uint64_t trials = 0;  ///< tentative parameters
  TimeNs begin_ns = 0, last_ns = 0, kept_ns = 0;
  TimeNs tentative_ns = 0;  ///< time in contact while a tentative setting was in force
  std::uint32_t unconfirmed = 0;
  ConfigurationStage stage = ConfigurationStage::as_set;
  bool tentative_applies = false;  ///< a tentative setting is in force
  bool commanded = false;
  bool proven = false;  ///< this start needs no confirmation any more
  bool running = false;
  bool restart_wanted = false;
  bool reported_not_kept = false;
};

/// A parameter that affects contact, or takes effect at a start, is tentative after it was set by telecommand. Any
/// telecommand that is accepted after it took effect confirms it. It is reverted when it has been tentative for
/// [contact] trial_s of contact, or when it keeps the flight from starting. Repeated starts step down to the last good
/// and to built-in parameters.
class Configuration {
 public:
  /// `mission` is the one that all components read.
  Configuration(FlightMemory& memory, MissionParameters& mission) : memory_(memory), mission_(mission) {
    guard_.seal(own_);
  }

  /// The first call of every start, when `mission` has the values of the mission file. It counts the start, finds out
  /// which store epoch the store belongs to, makes the settings in the store those of the stage, and puts them
  /// into `mission`. Faults of the store are passed on; those of the nonvolatile memory become events.
  Status begin(Store& store, const ConfigurationStart& start);
  /// The start has failed with `fault`. Reverts what is tentative and returns ok for another attempt, or returns
  /// `fault`.
  Status step_down(const Status& fault);
  [[nodiscard]] ConfigurationStage stage() const { return own_.stage; }
  /// Starts in a row before this one that no telecommand confirmed.
  [[nodiscard]] std::uint32_t unconfirmed() const { return own_.unconfirmed; }
  /// The mission's parameters with all settings, including those that take effect at the next start.
  [[nodiscard]] const MissionParameters& wanted() const { return own_.wanted; }
  /// Mission time was tied to the calendar.
  void epoch_is(double epoch_s);

  /// `parameters_contradict`: mission time, or the agency's epoch of the time format, would begin in the future.
  [[nodiscard]] Status check(const MissionParameters& wanted, TimeNs now) const;
  /// Writes records of what differs from wanted(), in an open transaction.
  Status write(const MissionParameters& wanted, TimeNs now);
  enum class Way : std::uint8_t {
    parameters,  ///< each by its kind: tentative or not
    file,        ///< all of them are tentative
    bounded      ///< a pass that begins or ends: it ends by itself and needs no confirmation
  };
  /// After the commit: puts into `mission` what takes effect at once.
  void accept(const MissionParameters& wanted, Way way);
  /// A telecommand was accepted that had come after the effect of everything tentative.
  void confirm();
  /// Call it once per minor frame. True when the time ended without a confirmation: wanted() and `mission` have
  /// changed.
  bool step(TimeNs now);
  /// The software was commanded to end: its next start needs no confirmation.
  void end_in_order(TimeNs now);
  /// Reverted settings stay in force until the next start, which should come soon.
  [[nodiscard]] bool restart_wanted() const { return own_.restart_wanted; }
  /// The next event to be reported; ok when there is none.
  Status updates();

  [[nodiscard]] FlightMemory& memory() { return memory_; }

 private:
  // configuration_start.cpp
  /// Nothing is kept before all of it is known. Whether the nonvolatile memory has never known of this store.
  Result<bool> find_identity(const ConfigurationStart& start, FlightMemoryContent& after);
  Status begin_store_epoch(const ConfigurationStart& start);
  Status write_settings();
  // configuration.cpp
  void enter(ConfigurationStage stage);
  MissionParameters put_above(const KeptSettings& settings, bool report_ignored);
  void revert(RevertReason reason);
  void check_tentative();
  void keep(const FlightMemoryContent& content);
  void report(const Status& event) { static_cast<void>(updates_.push_back(event)); }

  /// Guards every call that changes lasting state: checks it first and seals it afterwards.
  struct Use {
    explicit Use(Configuration& user);
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    ~Use() { configuration.guard_.seal(configuration.own_); }

    Configuration& configuration;
  };

  FlightMemory& memory_;
  MissionParameters& mission_;
  Store* store_ = nullptr;
  ConfigurationState own_;
  Guarded<ConfigurationState> guard_;
  FixedVector<Status, 8> updates_;
};

/// Of the parameter that says when mission time begins.
[[nodiscard]] std::uint64_t epoch_number();
/// Whether a parameter is tentative when it is set.
[[nodiscard]] bool needs_confirmation(std::size_t parameter);

}  // namespace ilp
