#include "fsw/downlink/delivery_queue.hpp"

#include <algorithm>
#include <cstring>

#include "fsw/base/argument.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/text.hpp"
#include "fsw/packets/cfdp_checksum.hpp"
#include "fsw/shared/find.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

/// A telecommand has four octets for a transaction number. Those that are open at once differ in them.
constexpr std::int64_t reported_a_number = 0xFFFFFFFF;

/// Records and events are small, and announce to the ground what to expect.
std::uint8_t priority_of(const char* name) {
  const bool first = std::strncmp(name, "records-", 8) == 0 || std::strncmp(name, "events-", 7) == 0;
  return first ? 0 : 1;
}

}  // namespace

DeliveryQueue::DeliveryQueue(Tables store, Clock& clock, const MissionParameters& mission, Scratch scratch,
                             const DeliveryBacklog* backlog)
    : store_(store), clock_(clock), mission_(mission), scratch_(scratch), backlog_(backlog) {}

Status DeliveryQueue::survey(std::uint64_t& bytes) {
  entries_.clear();
  bytes = 0;
  begin_ids<TransferRecord>(store_, last_id_);
  std::int64_t oldest_delivered = 0;
  TransferRecord record;
  for (;;) {  // bound: limits::max_transfers records
    ILP_TAKE(const Found found, find_next(store_, record.id, record));
    if (found == Found::nothing) break;
    if (last_id_ < record.id) last_id_ = record.id;
    if (found == Found::damaged) {
      // The content of the file is not known any more: it is sent again when its confirmation is overdue.
      ILP_TRY(erase<TransferRecord>(store_, record.id));
      continue;
    }
    bytes += record.data.bytes;
    if (record.state == TransferState::delivered && oldest_delivered == 0) oldest_delivered = record.id;
    Entry entry{record.id, {}};
    copy_text(entry.name, record.name);
    if (!entries_.push_back(entry)) break;
  }
  surveyed_ = true;
  if (!entries_.full() || oldest_delivered == 0) return {};
  // A delivery that was not queried in all this time: its file counts as lost and comes again.
  const auto is_oldest = [&](const Entry& entry) { return entry.id == oldest_delivered; };
  static_cast<void>(std::remove_if(entries_.begin(), entries_.end(), is_oldest));
  entries_.pop_back();
  return erase<TransferRecord>(store_, oldest_delivered);
}

Status DeliveryQueue::begin_file(const char* name) {
  open_ = false;
  if (name == nullptr || name[0] == 0 || std::strlen(name) >= sizeof(name_)) return out_of_range(Argument::file_name);
  std::uint64_t bytes = 0;
  ILP_TRY(survey(bytes));
  if (entries_.full() || static_cast<double>(bytes) >= 1024.0 * mission_.cfdp_queue_kib) {
    return {StatusCode::transfer_queue_full, static_cast<std::int64_t>(entries_.size()),
            static_cast<std::int64_t>(bytes)};
  }
  copy_text(name_, name);
  bytes_ = 0;
  open_ = true;
  return {};
}

Status DeliveryQueue::write(std::span<const std::uint8_t> bytes) {
  if (!open_) return out_of_range(Argument::open_file);
  auto& file = scratch_.as<DownlinkBuffers>().file;
  if (bytes.size() > file.size() - bytes_) {
    open_ = false;
    return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(bytes_ + bytes.size()),
            static_cast<std::int64_t>(file.size())};
  }
  if (!bytes.empty()) std::memcpy(file.data() + bytes_, bytes.data(), bytes.size());
  bytes_ += bytes.size();
  return {};
}

Status DeliveryQueue::erase_others_of(const char* name) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    const Entry entry = entries_[i];
    if (std::strcmp(entry.name, name) != 0) {
      entries_[kept++] = entry;
      continue;
    }
    const Status status = erase<TransferRecord>(store_, entry.id);
    if (!status.ok() && !status.is(StatusCode::not_found)) return status;
  }
  static_cast<void>(entries_.resize(kept));
  return {};
}

Status DeliveryQueue::end_file() {
  if (!open_) return out_of_range(Argument::open_file);
  open_ = false;
  ILP_TRY(erase_others_of(name_));
  const std::span<const std::uint8_t> file{scratch_.as<DownlinkBuffers>().file.data(), bytes_};
  cfdp::FileChecksum checksum(mission_.cfdp_checksum);
  checksum.add(file);
  TransferRecord record;
  record.id = ++last_id_;
  copy_text(record.name, name_);
  record.priority = priority_of(name_);
  record.bytes = static_cast<std::uint32_t>(bytes_);
  record.crc32 = crc32(file);
  record.checksum_type = mission_.cfdp_checksum;
  record.checksum = checksum.value();
  record.destination = mission_.cfdp_ground_entity;
  record.queued_ns = clock_.now();
  record.data.bytes = record.bytes;
  ILP_TRY(put(store_, record));
  if (!file.empty()) ILP_TRY(write_blob<TransferRecord>(store_, "data", record.id, 0, file));
  Entry entry{record.id, {}};
  copy_text(entry.name, name_);
  static_cast<void>(entries_.push_back(entry));
  return {};
}

Status DeliveryQueue::acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) {
  if (name == nullptr) return out_of_range(Argument::file_name);
  std::uint64_t unused = 0;
  if (!surveyed_) ILP_TRY(survey(unused));
  for (const Entry& entry : entries_) {
    if (std::strcmp(entry.name, name) != 0) continue;
    TransferRecord record;
    const Status found = get(store_, entry.id, record);
    // A rolled-back transaction leaves entries without a record, or with another one.
    if (is_gone(found)) continue;
    ILP_TRY(found);
    if (record.state != TransferState::delivered || std::strcmp(record.name, name) != 0) continue;
    bytes = record.bytes;
    crc32 = record.crc32;
    return erase<TransferRecord>(store_, record.id);
  }
  return StatusCode::not_ready;
}

Status DeliveryQueue::unsent(std::int64_t& bytes) {
  TransferRecord record;
  bytes = 0;
  if (backlog_ != nullptr) {
    bytes = backlog_->bytes;
    record.id = backlog_->known_through;
  }
  // Bounded by limits::max_transfers records.
  for (;;) {
    ILP_TAKE(const Found found, find_next(store_, record.id, record));
    if (found == Found::nothing) return {};
    const bool begins = record.state == TransferState::waiting || record.state == TransferState::sending;
    if (found == Found::valid && begins && !record.suspended) bytes += record.bytes - record.progress;
  }
}

Status request_transfer(StorePart<Changes<TransferRecord>> store, std::int64_t sequence, TransferWish wish) {
  TransferRecord record;
  bool any = false;
  for (;;) {  // bound: limits::max_transfers records
    ILP_TAKE(const Found found, find_next(store, record.id, record));
    if (found == Found::nothing) break;
    const std::int64_t reported = record.sequence & reported_a_number;
    const bool meant = found == Found::valid && (sequence == 0 || reported == sequence);
    if (!meant || record.state == TransferState::delivered) continue;
    record.wish = wish;
    ILP_TRY(amend(store, record));
    any = true;
  }
  return any ? Status{} : Status{StatusCode::not_found, sequence};
}

}  // namespace ilp
