#include "bsp/flight/store_epoch_merge.hpp"

#include <algorithm>
#include <limits>

#include "cfg/mission.hpp"
#include "cfg/schedule.hpp"
#include "fsw/base/time.hpp"
#include "fsw/shared/camera_on_record.hpp"
#include "fsw/shared/find.hpp"
#include "hal/store/newest_id.hpp"
#include "hal/store/record_bytes.hpp"

namespace ilp {
namespace {

/// Tables whose ids mean the same in every store epoch: there can be only one of each record.
constexpr RecordMask of_one_store_epoch =
    mask_of(RecordType::camera, RecordType::storage, RecordType::component, RecordType::checkpoint, RecordType::setting,
            RecordType::commanding, RecordType::timing, RecordType::identity, RecordType::node);
constexpr int batch_records = 200;
constexpr std::int64_t batch_bytes = 1 << 18;
constexpr std::int64_t events_per_resent_file = 64;
/// Longer ago than any time after which a confirmation is overdue.
constexpr TimeNs long_ago = std::numeric_limits<TimeNs>::min() / 8;

/// Transactions of bounded size.
class Batches {
 public:
  Batches(Store& store, DiskWait* wait) : store_(store), wait_(wait) {}
  Batches(const Batches&) = delete;
  Batches& operator=(const Batches&) = delete;
  ~Batches() {
    if (open_) store_.rollback();
  }
  /// Before what belongs together and writes about this many bytes.
  Status begin(std::int64_t bytes = 0) {
    if (open_ && (records_ >= batch_records || bytes_ + bytes > batch_bytes)) ILP_TRY(end());
    if (!open_) ILP_TRY(store_.begin());
    open_ = true;
    ++records_;
    bytes_ += bytes;
    return {};
  }
  Status end() {
    if (!open_) return {};
    open_ = false;
    records_ = 0;
    bytes_ = 0;
    if (wait_ != nullptr) wait_->at_work();
    return store_.commit();
  }

 private:
  Store& store_;
  DiskWait* wait_;
  bool open_ = false;
  int records_ = 0;
  std::int64_t bytes_ = 0;
};

/// What the copied store epoch says of itself.
struct Copied {
  IdentityRecord identity;
  CameraRecord camera;
  StartRecord start;
  std::int64_t first_keyframe_id = 0, last_keyframe_id = 0;
};

template <typename Record>
const Record& as(const std::uint8_t* record) {
  return *reinterpret_cast<const Record*>(record);
}

Status scan(MemoryCopy& copy, Copied& copied) {
  copied = {};
  copy.rewind();
  alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
  for (;;) {
    const RecordInfo* info = nullptr;
    const Status found = copy.next(info, record);
    if (found.is(StatusCode::not_found)) return {};
    ILP_TRY(found);
    if (info->type == RecordType::identity) copied.identity = as<IdentityRecord>(record);
    if (info->type == RecordType::start) copied.start = as<StartRecord>(record);
    if (info->type == RecordType::camera && id_of(record) == camera_id) copied.camera = as<CameraRecord>(record);
    if (info->type != RecordType::keyframe) continue;
    copied.last_keyframe_id = id_of(record);
    if (copied.first_keyframe_id == 0) copied.first_keyframe_id = copied.last_keyframe_id;
  }
}

bool same_store_epoch(const IdentityRecord& a, const IdentityRecord& b) {
  return a.life == b.life && a.keyframe_base == b.keyframe_base && a.record_base == b.record_base;
}

Status erase_if_there(Store& store, const RecordInfo& info, std::int64_t id) {
  const Status erased = store.erase(info, id);
  return erased.is(StatusCode::not_found) ? Status{} : erased;
}

class Merge {
 public:
  Merge(Store& database, MemoryCopy& copy, DiskWait* wait, const Copied& copied)
      : store_(database), copy_(copy), batches_(database, wait), copied_(copied) {}

  Status run(std::int64_t& records) {
    ILP_TRY(take_records(records));
    // The newest records are those of the copy now: what follows them is what the flight finds next.
    ILP_TRY(end_strips());
    ILP_TRY(forget_places());
    ILP_TRY(renumber_files());
    ILP_TRY(note_unsent());
    ILP_TRY(hand_in_frames());
    return take_state(records);
  }

 private:
  [[nodiscard]] bool is_earlier(RecordType type, std::int64_t id) const {
    return id <= (type == RecordType::frame || type == RecordType::downlink || type == RecordType::event
                      ? copied_.identity.record_base
                      : copied_.identity.keyframe_base);
  }

  Status put_copied(const RecordInfo& info, const std::uint8_t* record) {
    std::int64_t bytes = info.bytes;
    for_each_blob(info, [&](const FieldInfo& field, std::size_t) { bytes += blob_bytes(record, field); });
    ILP_TRY(batches_.begin(bytes));
    ILP_TRY(store_.put(info, record));
    Status status;
    for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
      std::uint8_t chunk[blob_chunk_bytes];
      const std::size_t all = blob_bytes(record, field);
      for (std::size_t at = 0; at < all && status.ok(); at += sizeof(chunk)) {
        const auto part = std::span(chunk).first(std::min(sizeof(chunk), all - at));
        status = copy_.read_blob(index, at, part);
        if (status.ok()) status = store_.write_blob(info, field.name, id_of(record), at, part);
      }
    });
    return status;
  }

  template <typename Wanted>
  Status take(Wanted wanted, std::int64_t& records) {
    copy_.rewind();
    alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
    for (;;) {
      const RecordInfo* info = nullptr;
      const Status found = copy_.next(info, record);
      if (found.is(StatusCode::not_found)) return batches_.end();
      ILP_TRY(found);
      if (!wanted(*info, record)) continue;
      ILP_TRY(put_copied(*info, record));
      ++records;
    }
  }

  Status take_records(std::int64_t& records) {
    return take(
        [](const RecordInfo& info, const std::uint8_t*) { return (of_one_store_epoch & mask_of(info.type)) == 0; },
        records);
  }

  /// Calls visit(record) for the records of the earlier store epoch after `after`.
  template <typename Record, typename Visit>
  Status for_each_earlier(Visit visit, std::int64_t after = 0) {
    Record record;
    for (;;) {
      ILP_TAKE(const Found found, find_next(store_, after, record));
      if (found == Found::nothing || !is_earlier(record_type<Record>, record.id)) return batches_.end();
      after = record.id;
      if (found == Found::valid) ILP_TRY(visit(record));
    }
  }

  Status end_strips() {
    return for_each_earlier<StripRecord>([&](StripRecord& strip) -> Status {
      if (strip.end != StripEnd::open) return {};
      strip.end = StripEnd::overlap_lost;
      ILP_TRY(batches_.begin());
      return put(store_, strip);
    });
  }

  /// Their slots are those of other places in the memory that goes on.
  Status forget_places() {
    return for_each_earlier<PlaceRecord>([&](PlaceRecord& place) -> Status {
      ILP_TRY(batches_.begin());
      return store_.erase(record_info<PlaceRecord>(), place.id);
    });
  }

  /// Confirmations are looked for among the newest files only.
  Status renumber_files() {
    std::int64_t newest = 0;
    ILP_TRY(newest_id<DownlinkRecord>(store_, newest));
    newest = std::max(newest, copied_.identity.record_base);
    return for_each_earlier<DownlinkRecord>([&](DownlinkRecord& file) -> Status {
      ILP_TRY(batches_.begin());
      ILP_TRY(store_.erase(record_info<DownlinkRecord>(), file.id));
      file.id = ++newest;
      return put(store_, file);
    });
  }

  /// A file that was never sent is noted as one that the ground has not confirmed: it is sent when it is overdue. Such
  /// a note has no bytes.
  Status note(DownlinkKind kind, std::int64_t subject, std::int64_t& newest) {
    DownlinkRecord file;
    file.id = ++newest;
    file.kind = kind;
    file.subject_id = subject;
    file.sent_ns = long_ago;
    file.records_through = kind == DownlinkKind::records && subject > 0 ? subject : 0;
    file.points_through = kind == DownlinkKind::points ? subject : 0;
    FixedText<sizeof(file.name)> name;
    name.add(kind == DownlinkKind::points ? "points-" : subject < 0 ? "events-" : "records-");
    name.add(subject < 0 ? -subject : subject, 6).add(".ilp");
    copy_text(file.name, name.c_str());
    ILP_TRY(batches_.begin());
    return put(store_, file);
  }

  Status note_unsent() {
    std::int64_t newest = 0, records_through = 0, points_through = 0, event = 0, products_through = 0;
    DownlinkRecord file;
    for (;;) {
      ILP_TAKE(const Found found, find_next(store_, newest, file));
      if (found == Found::nothing) break;
      newest = file.id;
      if (found == Found::damaged) continue;
      const auto raise = [&](RecordType type, std::int64_t to, std::int64_t& value) {
        if (is_earlier(type, to)) value = std::max(value, to);
      };
      raise(RecordType::keyframe, file.records_through, records_through);
      raise(RecordType::keyframe, file.points_through, points_through);
      // A file that was sent has a number of events that is not known: it is sent again.
      if (file.subject_id < 0) {
        raise(RecordType::event, -file.subject_id + (file.bytes == 0 ? events_per_resent_file : 0), event);
      }
    }
    newest = std::max(newest, copied_.identity.record_base);
    const auto look_for_image = [&](KeyframeRecord& keyframe) -> Status {
      ProductRecord image;
      ILP_TAKE(const bool made, find(store_, product_id(keyframe.id, ProductKind::image), image));
      if (made) products_through = keyframe.id;
      return {};
    };
    ILP_TRY(for_each_earlier<KeyframeRecord>(look_for_image));
    ILP_TRY(for_each_earlier<KeyframeRecord>(
        [&](KeyframeRecord& keyframe) -> Status {
          return keyframe.id <= products_through ? note(DownlinkKind::records, keyframe.id, newest) : Status{};
        },
        records_through));
    ILP_TRY(for_each_earlier<StructureRecord>(
        [&](StructureRecord& structure) -> Status {
          return structure.points.bytes != 0 ? note(DownlinkKind::points, structure.id, newest) : Status{};
        },
        points_through));
    ILP_TRY(for_each_earlier<EventRecord>(
        [&](EventRecord& reported) -> Status {
          if (reported.id < event) return {};
          event = reported.id + events_per_resent_file;
          return note(DownlinkKind::records, -reported.id, newest);
        },
        event - 1));
    return batches_.end();
  }

  /// Images from which the earlier store epoch has made no product yet become frames that have come now: they are
  /// examined again from the beginning.
  Status hand_in_frames() {
    std::int64_t newest = 0, keyframe_after = 0;
    ILP_TRY(newest_id<FrameRecord>(store_, newest));
    newest = std::max(newest, copied_.identity.record_base);
    return for_each_earlier<FrameRecord>([&](FrameRecord& frame) -> Status {
      if (frame.image.bytes == 0) return {};
      ILP_TAKE(const bool coded, is_coded(frame.id, keyframe_after));
      ILP_TRY(batches_.begin(coded ? 0 : frame.image.bytes));
      const std::int64_t before = frame.id;
      if (!coded) ILP_TRY(hand_in(frame, ++newest));
      frame.id = before;
      frame.image.bytes = 0;
      return put(store_, frame);
    });
  }

  Status hand_in(FrameRecord frame, std::int64_t id) {
    const std::int64_t before = frame.id;
    frame.id = id;
    frame.capture_id = 0;
    ILP_TRY(put(store_, frame));
    std::uint8_t chunk[blob_chunk_bytes];
    for (std::size_t at = 0; at < frame.image.bytes; at += sizeof(chunk)) {
      const auto part = std::span(chunk).first(std::min(sizeof(chunk), frame.image.bytes - at));
      const Status read = read_blob<FrameRecord>(store_, "image", before, at, part);
      // What cannot be read is black.
      if (is_gone(read)) std::fill(part.begin(), part.end(), std::uint8_t{0});
      if (!is_gone(read)) ILP_TRY(read);
      ILP_TRY(write_blob<FrameRecord>(store_, "image", id, at, part));
    }
    return {};
  }

  /// Whether the frame is a keyframe whose image is coded. Frames are asked for in ascending order.
  Result<bool> is_coded(std::int64_t frame_id, std::int64_t& keyframe_after) {
    KeyframeRecord keyframe;
    for (;;) {
      ILP_TAKE(const Found found, find_next(store_, keyframe_after, keyframe));
      if (found == Found::nothing || !is_earlier(RecordType::keyframe, keyframe.id)) return false;
      if (found == Found::valid && keyframe.frame_id > frame_id) return false;
      keyframe_after = keyframe.id;
      if (found == Found::damaged || keyframe.frame_id < frame_id) continue;
      ProductRecord image;
      return find(store_, product_id(keyframe.id, ProductKind::image), image);
    }
  }

  Status take_state(std::int64_t& records) {
    IdentityRecord before;
    ILP_TAKE(const bool known, find(store_, 1, before));
    const bool settings_known = !known || copied_.identity.configuration >= before.configuration;
    CameraRecord frozen;
    ILP_TAKE(const bool camera_known, find(store_, camera_id, frozen));
    const bool camera_stays = camera_known && frozen.frozen && !copied_.camera.frozen;
    ILP_TRY(erase_state(settings_known, camera_stays));
    ILP_TRY(take(
        [&](const RecordInfo& info, const std::uint8_t* record) {
          const std::int64_t id = id_of(record);
          if (info.type == RecordType::camera) return !camera_stays;
          if (info.type == RecordType::checkpoint) return is_taken(id, camera_stays);
          if (info.type == RecordType::setting) return takes_setting(id, settings_known);
          return info.type != RecordType::identity && (of_one_store_epoch & mask_of(info.type)) != 0;
        },
        records));
    IdentityRecord after = copied_.identity;
    if (!settings_known) after.configuration += before.configuration;
    ILP_TRY(batches_.begin());
    // It is last: with it the store epoch is in the database.
    ILP_TRY(put(store_, after));
    ++records;
    return batches_.end();
  }

  /// The storage manager counts what is held again. A search for a camera ends where one is known.
  static bool is_taken(std::int64_t checkpoint_id, bool camera_stays) {
    const std::int64_t number = checkpoint_id % 100;
    const auto component = static_cast<ComponentId>(number);
    return component != ComponentId::storage_manager && !(camera_stays && component == ComponentId::camera_calibrator);
  }

  /// Without the nonvolatile memory a flight in memory has only the settings that it was given itself, and an epoch of
  /// its own.
  bool takes_setting(std::int64_t id, bool settings_known) {
    const std::int64_t epoch = parameter_info(find_parameter("link", "mission_epoch_s")).number;
    SettingRecord setting;
    return settings_known || id != epoch || !get(store_, id, setting).ok();
  }

  Status erase_state(bool settings_known, bool camera_stays) {
    for (const RecordType type : {RecordType::camera, RecordType::setting, RecordType::checkpoint}) {
      if (type == RecordType::camera && camera_stays) continue;
      if (type == RecordType::setting && !settings_known) continue;
      const RecordInfo& info = record_info(type);
      alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
      std::int64_t after = 0;
      for (;;) {
        const Status found = store_.next(info, after, record);
        if (found.is(StatusCode::not_found)) break;
        if (!found.ok() && !found.is(StatusCode::record_damaged)) return found;
        after = found.ok() ? id_of(record) : found.a;
        ILP_TRY(batches_.begin());
        ILP_TRY(erase_if_there(store_, info, after));
      }
    }
    return batches_.end();
  }

  Store& store_;
  MemoryCopy& copy_;
  Batches batches_;
  const Copied& copied_;
};

Result<bool> is_merged(Store& database, const Copied& copied) {
  IdentityRecord identity;
  StartRecord start;
  ILP_TAKE(const bool known, find(database, 1, identity));
  if (!known || !same_store_epoch(identity, copied.identity)) return false;
  ILP_TAKE(const bool started, find(database, copied.start.id, start));
  return started && start.time_ns == copied.start.time_ns && start.alive_ns == copied.start.alive_ns;
}

}  // namespace

Result<bool> follows(Store& database, MemoryCopy& copy) {
  Copied copied;
  ILP_TRY(scan(copy, copied));
  ILP_TAKE(const bool merged, is_merged(database, copied));
  if (merged) return true;
  IdentityRecord identity;
  ILP_TAKE(const bool known, find(database, 1, identity));
  if (known && !same_store_epoch(identity, copied.identity) &&
      identity.keyframe_base >= copied.identity.keyframe_base) {
    return false;
  }
  std::int64_t newest = 0;
  ILP_TRY(newest_id<KeyframeRecord>(database, newest));
  const bool of_the_copy = newest >= copied.first_keyframe_id && newest <= copied.last_keyframe_id;
  return newest <= copied.identity.keyframe_base || of_the_copy;
}

Status merge_store_epoch(Store& database, MemoryCopy& copy, DiskWait* wait, std::int64_t& records) {
  records = 0;
  Copied copied;
  ILP_TRY(scan(copy, copied));
  ILP_TAKE(const bool merged, is_merged(database, copied));
  return merged ? Status{} : Merge(database, copy, wait, copied).run(records);
}

}  // namespace ilp
