// Manages the parameters in force: those of the mission file, replaced by settings from telecommands. Settings that
// keep the ground from reaching the flight are reverted (docs/getting-back-in.md).
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

/// Input of a start.
struct ConfigurationStart {
  Status loaded;           ///< result of FlightMemory::load
  std::int64_t utc_s = 0;  ///< calendar time, s of UTC since 1958; 0: not known
  bool commanded = false;  ///< there is a link for telecommands, so that the ground can confirm
  /// The reason why the store replaces another one; ok: it does not. With `store_in_memory` the storage budget is
  /// limited to that of the parameters that begin() finds.
  Status store = {};
};

/// Lasting state. It has a copy and a checksum, so that a flipped bit is detected before it takes effect.
struct ConfigurationState {
  MissionParameters base;    ///< parameters of the mission file
  MissionParameters good;    ///< `base` with confirmed settings
  MissionParameters wanted;  ///< `base` with all settings
  IdentityRecord identity;
  double most_storage_mib = 0;  ///< limit of the storage budget; 0: none
  std::uint64_t trials = 0;     ///< number of tentative parameters
  TimeNs begin_ns = 0, last_ns = 0, kept_ns = 0;
  TimeNs tentative_ns = 0;        ///< time in contact while a tentative setting was in force
  std::uint32_t unconfirmed = 0;  ///< starts in a row before this one without a confirmation
  ConfigurationStage stage = ConfigurationStage::as_set;
  bool tentative_applies = false;  ///< a tentative setting is in force
  bool commanded = false;
  bool proven = false;  ///< this start is confirmed, or has run long enough
  bool running = false;
  bool restart_wanted = false;
  bool reported_not_kept = false;
};

/// A parameter that affects contact, or takes effect at a start, is tentative after it was set by telecommand. It is
/// confirmed by any telecommand that arrives after the setting took effect and is accepted. It is reverted after
/// [contact] trial_s of contact without a confirmation, or if the flight cannot start with it. The third start in a row
/// without a confirmation uses the last good parameters, later ones the built-in parameters.
class Configuration {
 public:
  /// `mission` is the object that all components read.
  Configuration(FlightMemory& memory, MissionParameters& mission) : memory_(memory), mission_(mission) {
    guard_.seal(own_);
  }

  /// The first call of every start, when `mission` has the values of the mission file. It counts the start, determines
  /// the store epoch, chooses the stage, puts the parameters of the stage into `mission`, and writes the settings to
  /// the store. Returns faults of the store; those of the nonvolatile memory become events.
  Status begin(Store& store, const ConfigurationStart& start);
  /// Call it when the start has failed with `fault`. If tentative settings may be the cause it reverts them and returns
  /// ok for another attempt; otherwise it returns `fault`.
  Status step_down(const Status& fault);
  [[nodiscard]] ConfigurationStage stage() const { return own_.stage; }
  /// Number of starts in a row before this one that no telecommand has confirmed.
  [[nodiscard]] std::uint32_t unconfirmed() const { return own_.unconfirmed; }
  /// The mission's parameters with all settings, including those that take effect at the next start.
  [[nodiscard]] const MissionParameters& wanted() const { return own_.wanted; }
  /// Sets the mission epoch, s of UTC since 1958, once it is known from the calendar.
  void epoch_is(double epoch_s);

  /// Returns `parameters_contradict` if mission time, or the agency's epoch of the time format, would begin after
  /// `now`.
  [[nodiscard]] Status check(const MissionParameters& wanted, TimeNs now) const;
  /// Writes setting records for the parameters that differ from wanted(), in an open transaction.
  Status write(const MissionParameters& wanted, TimeNs now);
  /// How parameters are set, which decides whether they are tentative.
  enum class Way : std::uint8_t {
    parameters,  ///< each as needs_confirmation() says
    file,        ///< all of them are tentative
    bounded      ///< none: begin or end of a pass, whose effect ends by itself
  };
  /// Call it after the commit of write(). Puts parameters that take effect at once into `mission`.
  void accept(const MissionParameters& wanted, Way way);
  /// Call it when a telecommand was accepted that arrived after the latest settings took effect. Confirms the tentative
  /// settings that are in force.
  void confirm();
  /// Call it once per minor frame. Returns true if settings were reverted for lack of a confirmation: wanted() and
  /// `mission` have then changed.
  bool step(TimeNs now);
  /// Call it when the software ends by command. The next start then does not count as unconfirmed.
  void end_in_order(TimeNs now);
  /// A restart is needed: reverted settings stay in force until the next start, or the lasting state is damaged.
  [[nodiscard]] bool restart_wanted() const { return own_.restart_wanted; }
  /// The next event to be reported; ok when there is none.
  Status updates();

  [[nodiscard]] FlightMemory& memory() { return memory_; }

 private:
  // configuration_start.cpp
  /// Determines the store epoch of the store, or begins a new one. Returns true if the nonvolatile memory has no
  /// knowledge of this store.
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

  /// Exists during every call that changes the lasting state: checks the state first and seals it at the end.
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

/// Number of the parameter mission_epoch_s.
[[nodiscard]] std::uint64_t epoch_number();
/// Whether a parameter is tentative when it is set.
[[nodiscard]] bool needs_confirmation(std::size_t parameter);

}  // namespace ilp
