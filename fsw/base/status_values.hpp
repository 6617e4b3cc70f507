// The two values of a Status: a name and a type for each, from the rows of status_list.inc.
#pragma once

#include <cstdint>

#include "fsw/base/enumeration.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// Rows (name, unit, values per unit, meaning). Values without a unit are written as numbers, or by the names that
/// bsp/flight/status_text.hpp knows.
#define ILP_VALUE_TYPES(ROW)                                                      \
  ROW(none, "", 1, "always 0")                                                    \
  ROW(number, "", 1, "")                                                          \
  ROW(id, "", 1, "of the record that the name of the value says")                 \
  ROW(hexadecimal, "", 1, "in hexadecimal digits")                                \
  ROW(thousandths, "", 1000, "-2147483648: no number")                            \
  ROW(bytes, "bytes", 1, "")                                                      \
  ROW(bits, "bits", 1, "")                                                        \
  ROW(pixels, "px", 1, "")                                                        \
  ROW(millipixels, "px", 1000, "")                                                \
  ROW(metres, "m", 1, "")                                                         \
  ROW(seconds, "s", 1, "")                                                        \
  ROW(milliseconds, "ms", 1, "")                                                  \
  ROW(microseconds, "us", 1, "")                                                  \
  ROW(nanoseconds, "ns", 1, "")                                                   \
  ROW(millihertz, "Hz", 1000, "")                                                 \
  ROW(size, "px", 1, "100000 x width + height")                                   \
  ROW(error, "", 1, "errno of the operating system")                              \
  ROW(fault, "", 1, "code of another row")                                        \
  ROW(component, "", 1, "number; 0: package")                                     \
  ROW(stages, "", 1, "bit k: component k + 1")                                    \
  ROW(table, "", 1, "type of a record")                                           \
  ROW(parameter, "", 1, "number; 0: none")                                        \
  ROW(format, "", 1, "or a four-character code of Linux")                         \
  ROW(findings, "", 1, "about the camera's driver, bit by bit (docs/onboard.md)") \
  ROW(argument, "", 1, "")                                                        \
  ROW(arena, "", 1, "")                                                           \
  ROW(brightness, "", 1, "")                                                      \
  ROW(calibration_verdict, "", 1, "")                                             \
  ROW(codec_stage, "", 1, "")                                                     \
  ROW(compute_fault, "", 1, "")                                                   \
  ROW(compute_kind, "", 1, "")                                                    \
  ROW(condition, "", 1, "of CFDP (CCSDS 727.0-B-5, table 5-5)")                   \
  ROW(file_kind, "", 1, "")                                                       \
  ROW(flag, "", 1, "")                                                            \
  ROW(frame_damage, "", 1, "")                                                    \
  ROW(intrinsic, "", 1, "")                                                       \
  ROW(load_reason, "", 1, "")                                                     \
  ROW(memory_source, "", 1, "")                                                   \
  ROW(overlap_verdict, "", 1, "")                                                 \
  ROW(pdu_fault, "", 1, "")                                                       \
  ROW(rectification_fault, "", 1, "")                                             \
  ROW(reduced_work, "", 1, "")                                                    \
  ROW(relation, "", 1, "of mission parameters, which must hold")                  \
  ROW(revert_reason, "", 1, "")                                                   \
  ROW(self_test, "", 1, "")                                                       \
  ROW(start_reason, "", 1, "")                                                    \
  ROW(strip_end, "", 1, "")                                                       \
  ROW(strip_frame_verdict, "", 1, "")

enum class ValueType : std::uint8_t {
#define ILP_VALUE_TYPE(name, unit, per_unit, meaning) name,
  ILP_VALUE_TYPES(ILP_VALUE_TYPE)
#undef ILP_VALUE_TYPE
      count
};

struct ValueTypeInfo {
  const char* name;
  const char* unit;
  std::int32_t per_unit;  ///< the stored number is the value in the unit times per_unit
  const char* meaning;
};
[[nodiscard]] const ValueTypeInfo& info_of(ValueType type);

struct StatusValue {
  const char* name = "";
  ValueType type = ValueType::none;
};
struct StatusValues {
  StatusValue a = {}, b = {};
};
[[nodiscard]] StatusValues status_values(StatusCode code);

/// The value of `unsupported_format`, which may instead be a four-character code of Linux.
ILP_ENUMERATION(FormatFault, (0, other, "a file of another kind"), (1, not_pgm, "no binary PGM file"),
                (2, pgm_depth, "a PGM file with other than 255 levels"),
                (3, y4m_sampling, "a Y4M stream of another chroma sampling"), (4, y4m_rate, "the rate of a Y4M stream"),
                (5, jpeg_coding, "a JPEG file that needs the whole picture in memory"))

[[nodiscard]] constexpr Status not_supported(FormatFault fault) {
  return {StatusCode::unsupported_format, static_cast<std::int64_t>(fault)};
}

/// Damage of a frame of the camera (camera_frames_refused).
ILP_ENUMERATION(FrameDamage, (1, flagged, "flagged by the driver"), (2, too_short, "too few bytes"),
                (3, too_long, "too many bytes"), (4, undecodable, "a JPEG file that is none or cannot be decoded"))

/// The value of exposure_limited.
ILP_ENUMERATION(Brightness, (1, too_dark, "too dark"), (2, too_bright, "too bright"))

/// Where the bytes of damaged memory were taken from (memory_damaged).
ILP_ENUMERATION(MemorySource, (1, checkpoint, "from the checkpoint"), (2, copy, "from a copy"),
                (3, new_process, "by a new process"))

/// Why a pair cannot be rectified.
ILP_ENUMERATION(RectificationFault, (1, no_baseline, "no baseline"), (2, axes_apart, "optical axes too far apart"),
                (3, epipole_near, "the epipole lies in an image or near it"), (4, no_common_ground, "no common ground"),
                (5, too_large, "too large for the limits"), (6, no_parallax, "no ground moves enough"),
                (7, poses_contradict, "the poses contradict the images"))

}  // namespace ilp
