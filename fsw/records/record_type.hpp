// Which table a record belongs to, as a constant of its type.
#pragma once

#include "fsw/records/records.hpp"

namespace ilp {

/// X(Record, type) for every record, in the order of RecordType.
#define ILP_RECORDS(X)                         \
  X(CameraRecord, camera)                      \
  X(FrameRecord, frame)                        \
  X(CaptureRecord, capture)                    \
  X(OverlapRecord, overlap)                    \
  X(StripRecord, strip)                        \
  X(KeyframeRecord, keyframe)                  \
  X(CalibrationRecord, calibration)            \
  X(PoseRecord, pose)                          \
  X(StructureRecord, structure)                \
  X(CalibrationCheckRecord, calibration_check) \
  X(DepthRecord, depth)                        \
  X(RichnessRecord, richness)                  \
  X(ProductRecord, product)                    \
  X(DownlinkRecord, downlink)                  \
  X(StorageRecord, storage)                    \
  X(CommandRecord, command)                    \
  X(EventRecord, event)                        \
  X(ComponentRecord, component)                \
  X(CheckpointRecord, checkpoint)              \
  X(TransferRecord, transfer)                  \
  X(UplinkRecord, uplink)                      \
  X(SettingRecord, setting)                    \
  X(ScheduledRecord, scheduled)                \
  X(CommandingRecord, commanding)              \
  X(StartRecord, start)                        \
  X(TimingRecord, timing)                      \
  X(IdentityRecord, identity)

template <typename Record>
inline constexpr RecordType record_type = RecordType::count;
#define ILP_TYPE(Record, type) \
  template <>                  \
  inline constexpr RecordType record_type<Record> = RecordType::type;
ILP_RECORDS(ILP_TYPE)
#undef ILP_TYPE

/// The tables of some records.
template <typename... Records>
inline constexpr RecordMask tables_of = (RecordMask{0} | ... | mask_of(record_type<Records>));

}  // namespace ilp
