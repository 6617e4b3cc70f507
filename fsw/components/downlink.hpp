// Sends what is worth most and hears what has arrived: Product -> Acknowledged (file formats: docs/outbox.md).
#pragma once

#include "cfg/mission.hpp"
#include "fsw/components/checkpoint.hpp"
#include "fsw/executive/component.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/link.hpp"

namespace ilp {

/// One file a step, within the link's mean rate. Records of a keyframe go before its products, products by priority,
/// events when there are enough of them or time has passed. A file is done with only when the ground has confirmed its
/// size and its CRC. Without contact everything waits.
class Downlink final : public Component {
 public:
  Downlink(Store& store, Link& link, Clock& clock, const MissionParameters& mission);

  [[nodiscard]] const char* name() const override { return "downlink"; }
  Status restore() override;
  StepResult step(TimeNs deadline) override;

  /// Everything that there is has been sent, and confirmed.
  [[nodiscard]] bool drained() const { return drained_; }

 private:
  struct State {
    std::int64_t credit_bytes = 0;  ///< what the link can take now; negative after a large file
    TimeNs credited_ns = 0;
    std::int64_t last_downlink_id = 0;
    std::int64_t records_through = 0;  ///< keyframes up to it have been sent as records
    std::int64_t events_through = 0;
    std::int64_t event_files = 0;
    std::int64_t housekeeping_steps = 0;  ///< fingerprint of the housekeeping last sent
    TimeNs events_sent_ns = 0;
    std::int64_t acknowledged_through = 0;  ///< downlinks up to it are all acknowledged
  };
  static constexpr std::size_t chunk_bytes = 4096;

  void credit(State& after);
  Status hear(State& after, bool& heard);
  Status send_next(State& after, bool& sent);
  Status send_records(std::int64_t keyframe_id, State& after);
  Status send_product(const ProductRecord& product, State& after);
  Status send_events(std::int64_t housekeeping_steps, State& after);
  Status housekeeping_fingerprint(std::int64_t& steps);
  Status close_file(DownlinkKind kind, std::int64_t subject_id, State& after);

  /// Sends the next file, if there is contact; its loss and its return are events.
  Status send_in_contact(State& after, bool& sent);
  Status open(const char* name);
  Status write(std::span<const std::uint8_t> bytes);
  Status write_u8(std::uint8_t value);
  Status write_u32(std::uint32_t value);
  Status write_entry(const RecordInfo& info, const void* record);
  Status write_blob_of(const RecordInfo& info, const char* field, std::int64_t id, std::uint32_t bytes);
  template <typename Record>
  Status write_if_present(std::int64_t id);
  template <typename Record>
  Status write_newest();

  Store& store_;
  Link& link_;
  Clock& clock_;
  const MissionParameters& mission_;
  Cursor cursor_;
  State state_;
  Status event_;
  bool drained_ = false;
  bool contact_lost_ = false;
  TimeNs contact_lost_ns_ = 0;
  std::int64_t asked_through_ = 0;  ///< downlinks up to it have been asked for in this round
  // The file being written.
  char name_[32] = {};
  std::uint32_t bytes_ = 0;
  std::uint32_t crc_ = 0;
  std::uint8_t chunk_[chunk_bytes] = {};
};

}  // namespace ilp
