// Which parameters the flight has: those of its mission file, above them what was set by telecommand, and how it comes
// back from settings under which nobody reaches it (docs/getting-back-in.md).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/base/checksum.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/shared/flight_memory.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Of the event configuration_reverted.
enum class RevertReason : std::uint8_t {
  start_failed = 1,   ///< the flight could not start with it
  not_confirmed = 2,  ///< nobody was heard for [contact] trial_s of contact
  many_starts = 3     ///< the third start in a row that nobody confirmed
};

/// What is known before a start.
struct ConfigurationStart {
  Status loaded;                ///< what FlightMemory::load said
  std::int64_t utc_s = 0;       ///< the calendar, seconds since 1958; 0: none
  bool commanded = false;       ///< there is a link for telecommands: somebody can confirm
  bool another_before = false;  ///< the store stands in for another one
  double most_storage_mib = 0;  ///< what the store has room for; 0: what the parameters say
};

/// A parameter that decides about contact, or acts with a start, is on trial when it was set by telecommand: until any
/// telecommand is accepted behind its effect. Then it is good. What is on trial for [contact] trial_s of contact, or
/// keeps the flight from starting, is given up; repeated starts step down to the last good and to built-in parameters.
class Configuration {
 public:
  /// `mission` is the one that everybody reads.
  Configuration(FlightMemory& memory, MissionParameters& mission) : memory_(memory), mission_(mission) { seal(); }

  /// First of all at every start, when `mission` has what the mission file says: counts the start, finds out which
  /// life of the flight the store is of, makes the settings in it those of the stage, and puts them into `mission`.
  /// Faults of the store are passed on; those of the small memory are news.
  Status begin(Store& store, const ConfigurationStart& start);
  /// The start has failed with `fault`: what is on trial is given up, and it may be tried again. Else `fault`.
  Status step_down(const Status& fault);
  [[nodiscard]] ConfigurationStage stage() const { return own_.stage; }
  /// Starts in a row before this one that nobody confirmed.
  [[nodiscard]] std::uint32_t unconfirmed() const { return own_.unconfirmed; }
  /// The mission's parameters with all that is set, also what takes effect with the next start only.
  [[nodiscard]] const MissionParameters& wanted() const { return own_.wanted; }
  /// Mission time was tied to the calendar.
  void epoch_is(double epoch_s);

  /// What can be told to be senseless: `parameters_contradict` (a = 14: mission time would begin in the future; 15: the
  /// agency's epoch, by which times are told, is in the future).
  [[nodiscard]] Status check(const MissionParameters& wanted, TimeNs now) const;
  /// In an open transaction: the records of what differs from wanted().
  Status write(const MissionParameters& wanted, TimeNs now);
  enum class Way : std::uint8_t {
    parameters,  ///< each by its kind: on trial or not
    file,        ///< all on trial
    bounded      ///< a pass that begins or ends: it is over some time, and needs no trial
  };
  /// Behind the commit: what takes effect at once does.
  void settle(const MissionParameters& wanted, Way way);
  /// A telecommand was accepted that had come behind everything that has acted.
  void confirm();
  /// Once per minor frame. True when a trial has ended without an answer: wanted() and `mission` have changed.
  bool step(TimeNs now);
  /// The end of the software was ordered: its start needs no confirmation.
  void end_in_order(TimeNs now);
  /// What was given up stays in force until the next start, which should come soon.
  [[nodiscard]] bool restart_wanted() const { return own_.restart_wanted; }
  /// The next event to be told; ok when there is none.
  Status news();

  [[nodiscard]] FlightMemory& memory() { return memory_; }

 private:
  Status find_identity(const ConfigurationStart& start);
  Status begin_life(const ConfigurationStart& start);
  Status take_settings(FlightMemoryContent& after);
  Status write_settings();
  void enter(ConfigurationStage stage);
  MissionParameters put_above(const KeptSettings& settings, bool tell_ignored);
  MissionParameters built_in();
  void revert(RevertReason reason);
  void look_at_trial();
  [[nodiscard]] bool acted(const FlightMemoryContent& content, std::size_t index) const;
  [[nodiscard]] bool on_trial(const FlightMemoryContent& content, std::size_t index) const;
  void keep(const FlightMemoryContent& content);
  void tell(const Status& event) { static_cast<void>(news_.push_back(event)); }

  /// What lasts: a copy is kept, so that a flipped bit is noticed before it acts.
  struct Own {
    MissionParameters base;    ///< of the mission file
    MissionParameters good;    ///< with what is good
    MissionParameters wanted;  ///< with what is set
    IdentityRecord identity;
    double most_storage_mib = 0;
    std::uint64_t trials = 0;  ///< parameters on trial
    TimeNs begin_ns = 0, last_ns = 0, kept_ns = 0;
    TimeNs trial_ns = 0;  ///< of contact, while something on trial was in force
    std::uint32_t unconfirmed = 0;
    ConfigurationStage stage = ConfigurationStage::as_set;
    bool trial_acts = false;  ///< something on trial is in force
    bool commanded = false;
    bool proven = false;  ///< this start needs no confirmation any more
    bool running = false;
    bool restart_wanted = false;
    bool told_not_kept = false;
  };
  /// Of every call that changes what lasts.
  class Use {
   public:
    explicit Use(Configuration& configuration) : configuration_(configuration) { configuration_.check_own(); }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    ~Use() { configuration_.seal(); }

   private:
    Configuration& configuration_;
  };
  void check_own();
  void seal() { guard_.seal(own_); }

  FlightMemory& memory_;
  MissionParameters& mission_;
  Store* store_ = nullptr;
  Own own_;
  Guarded<Own> guard_;
  FixedVector<Status, 8> news_;
};

/// What is put on trial when it is set.
[[nodiscard]] bool needs_trial(std::size_t parameter);

}  // namespace ilp
