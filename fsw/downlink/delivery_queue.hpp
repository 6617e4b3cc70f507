// The Link to which Downlink writes files that are sent by CFDP. Each file becomes a record `transfer`, which the
// component FileDelivery delivers to the ground (docs/file-delivery.md).
#pragma once

#include <array>

#include "cfg/limits.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/checksum.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/downlink/downlink_buffers.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/link.hpp"
#include "hal/store/store_view.hpp"

namespace ilp {

/// Counts for housekeeping.
struct DeliveryCounts {
  std::uint32_t pdus_in = 0, pdus_out = 0;
  std::uint32_t rejected = 0;   ///< malformed PDUs
  std::uint32_t ignored = 0;    ///< PDUs for another entity, or of an unknown transaction
  std::uint32_t delivered = 0;  ///< files that the ground has received completely
  std::uint32_t refused = 0;    ///< transactions that the ground ended without accepting the file
  std::uint32_t cancelled = 0;
  std::uint32_t events_lost = 0;
};
/// The data that FileDelivery still has to send, which it counts in every step.
struct DeliveryBacklog {
  std::int64_t known_through = 0;  ///< id of the newest transfer that is counted
  std::int64_t bytes = 0;          ///< excludes transfers that are suspended, rest or wait after a fault
};
/// Counts and backlog of FileDelivery, for other components to read.
struct DeliveryFigures {
  DeliveryCounts counts;
  DeliveryBacklog backlog;
};

/// All records are written in the transaction that the caller has opened. A file is therefore queued if and only if the
/// caller commits the record that it has sent the file.
class DeliveryQueue final : public Link {
 public:
  using Tables = StorePart<Writes<TransferRecord>, Erases<TransferRecord>>;
  using Scratch = StepScratch<DownlinkBuffers>;

  /// A file is built in `scratch` and must be begun and ended in the same step. `backlog` gives the unsent bytes of the
  /// transfers that FileDelivery knows, because their records state the progress only roughly; it may be null.
  DeliveryQueue(Tables store, Clock& clock, const MissionParameters& mission, Scratch scratch,
                const DeliveryBacklog* backlog = nullptr);

  /// Returns `transfer_queue_full` if limits::max_transfers files or cfdp_queue_kib KiB are queued: try again later.
  Status begin_file(const char* name) override;
  /// Returns `capacity_exceeded`, and abandons the file, if it exceeds limits::max_transfer_bytes.
  Status write(std::span<const std::uint8_t> bytes) override;
  /// Queues the file. It replaces a queued file of the same name.
  Status end_file() override;
  /// Gives size and CRC of a file that the ground has received completely and checked, and erases its transfer. Returns
  /// `not_ready` before, and again after the caller has committed the transaction.
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override;
  /// Gives the unsent bytes: the backlog, and the files that are not counted there yet.
  Status unsent(std::int64_t& bytes) override;

  /// The memory of this object that never changes.
  [[nodiscard]] std::span<const std::byte> constants() const { return memory_between(this, &entries_); }

 private:
  struct Entry {
    std::int64_t id;
    char name[32];
  };

  /// Reads all transfers into `entries_`; `bytes` gets the size of their files. Erases damaged records, and, if the
  /// queue is full, the oldest delivered transfer.
  Status survey(std::uint64_t& bytes);
  Status erase_others_of(const char* name);

  Tables store_;
  Clock& clock_;
  const MissionParameters& mission_;
  Scratch scratch_;
  const DeliveryBacklog* backlog_;
  FixedVector<Entry, limits::max_transfers> entries_;
  bool surveyed_ = false;
  std::int64_t last_id_ = 0;  ///< the largest id so far: ids of erased records are not used again in this boot
  bool open_ = false;
  char name_[32] = {};
  std::size_t bytes_ = 0;
};

/// Stores the ground's request for a transfer, in an open transaction. `sequence` is the transaction sequence number,
/// or the last four octets of a longer one; 0 means all transfers. Returns `not_found` if there is no such transfer.
Status request_transfer(StorePart<Changes<TransferRecord>> store, std::int64_t sequence, TransferWish wish);

}  // namespace ilp
