// The data of Downlink, and the base class of its parts: confirmations, the choice of the next file, and making files.
#pragma once

#include <array>

#include "cfg/link_shares.hpp"
#include "cfg/mission.hpp"
#include "fsw/downlink/downlink_buffers.hpp"
#include "fsw/downlink/outgoing_file.hpp"
#include "fsw/downlink/pass_planner.hpp"
#include "fsw/downlink/quarantine_list.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "fsw/shared/find.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

using DownlinkTables = StageStore<ComponentId::downlink>;

inline constexpr std::size_t max_late_files = 32;
/// Stands for no limit: more bytes than any link carries, and few enough that sums do not overflow.
inline constexpr std::int64_t no_limit_bytes = std::int64_t{1} << 50U;

/// A file that must be sent although later ones have been sent: it was quarantined, or not confirmed in time.
struct LateFile {
  FileClass kind = FileClass::records;
  std::int64_t id = 0;  ///< id of the keyframe, of the structure, or of the first event of the file
  bool operator==(const LateFile&) const = default;
};

struct DownlinkWiring {
  DownlinkTables store;
  Link& link;
  Clock& clock;
  const MissionParameters& mission;
  StepScratch<DownlinkBuffers> scratch;
};

struct DownlinkState {
  std::int64_t credit_bytes = 0;  ///< bytes that the link can take now; negative after a large file
  TimeNs credited_ns = 0;
  std::int64_t last_downlink_id = 0;
  std::int64_t records_through = 0;  ///< records of keyframes up to this one have been sent, except late ones
  std::int64_t points_through = 0;   ///< sparse points of keyframes up to this one have been sent, except late ones
  std::int64_t events_through = 0;
  std::int64_t event_files = 0;
  std::int64_t housekeeping_steps = 0;  ///< fingerprint of the housekeeping that was sent last
  TimeNs events_sent_ns = 0;
  std::int64_t acknowledged_through = 0;  ///< downlink records up to this one are all acknowledged
  std::int64_t next_pass = 0;             ///< number of the pass after the present one
  std::int64_t pass_bytes = 0;            ///< bytes sent in the present pass
  std::int64_t overdue_bytes = 0;         ///< bytes of overdue first layers in `pass_bytes`
  /// Id of the newest product when the present pass began, when the previous one began, and so on.
  std::array<std::int64_t, limits::max_overdue_passes + 1> product_at_pass{};
  std::array<std::int64_t, file_classes> owed_bytes{};  ///< credit of each class
  std::int64_t planned_bytes = 0;                       ///< size of the next file of products, as far as it is known
  std::int64_t check_products_from = 0;                 ///< next product for check_products(); 0: none
  FixedVector<LateFile, max_late_files> late;
};
/// The subject of a file.
struct FileSubject {
  FileClass kind = FileClass::count;  ///< `count`: no file yet
  std::int64_t id = 0;
};
struct DownlinkWork {
  Status event;
  bool drained = false;
  bool contact_lost = false;
  TimeNs contact_lost_ns = 0;
  std::int64_t asked_through = 0;  ///< downlink records up to this one have been queried in this round
  TimeNs newest_sent_ns = 0;
  std::int64_t free_bytes = 0;  ///< bytes that the link can still take in this pass
  FileSubject subject;
  bool store_failed = false;     ///< the store refused a write
  bool something_waits = false;  ///< a class that was asked has a file
  bool changed = false;          ///< the state has changed although no file was sent
  int confirm_alone = 0;         ///< number of next confirmations that are committed one by one, after a fault
  QuarantineList<32> quarantine;
};
struct DownlinkWorkspace {
  DownlinkWorkspace(DownlinkTables store, Link& link) : file(store, link) {}

  OutgoingFile file;
  FixedVector<std::int64_t, limits::max_refine_requests> requests;  ///< keyframes
  CandidateList candidates;
  PassPlan plan;
  PlanWorkspace planning;
};

/// Base class of the parts. In all functions `after` is the state after the step, which is committed at its end.
class DownlinkPart {
 public:
  using State = DownlinkState;

  DownlinkPart(const DownlinkWiring& wiring, const Cursor& cursor, State& state, DownlinkWork& work,
               DownlinkWorkspace& workspace)
      : wiring_(wiring), cursor_(cursor), state_(state), work_(work), workspace_(workspace) {}

 protected:
  /// Whether a quarantined file is abandoned: it is sent without its unreadable parts, or left out.
  [[nodiscard]] bool abandoned(FileClass kind, std::int64_t id) const;
  /// Whether a quarantined file must not be tried yet.
  [[nodiscard]] bool rests(FileClass kind, std::int64_t id) const;
  /// Notes that a file of `bytes` bytes waits. Returns whether it may be sent now: it has at most `most` bytes and
  /// fits.
  bool may_go(const State& after, std::int64_t bytes, std::int64_t most);
  /// Whether a file of `bytes` bytes can be sent before the pass ends.
  [[nodiscard]] bool fits(const State& after, std::int64_t bytes) const;

  const DownlinkWiring& wiring_;
  const Cursor& cursor_;
  State& state_;
  DownlinkWork& work_;
  DownlinkWorkspace& workspace_;
};

}  // namespace ilp
