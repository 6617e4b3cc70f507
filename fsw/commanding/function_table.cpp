#include "fsw/commanding/function_table.hpp"

#include <cstring>

namespace ilp {
namespace {

constexpr std::uint8_t tag = 8;  // octets

constexpr FunctionInfo table[] = {
    {Function::capture, "CAPTURE", "[tag, up to 8 octets]", 0, false, tag,
     "an image now; from the schedule, at the release time itself. Completed when it is exposed"},
    {Function::capture_at, "CAPTAT", "TIME [tag, up to 8 octets]", 0, true, tag,
     "an image at a time. Completed when it is exposed"},
    {Function::capture_series, "CAPTSER", "TIME, u32 interval in ms, u16 number", 6, true, 0,
     "images at equal intervals, the first at the time. A progress report for each; completed when all are exposed"},
    {Function::capture_mode, "CAPMODE", "u8 mode", 1, false, 0,
     "0 regular interval, 1 by forecast overlap, 2 only by telecommand: sets acquisition.capture_mode"},
    {Function::flush_window, "FLUSH", "", 0, false, 0,
     "ends the open strip. Completed when the poses of its last keyframes are final"},
    {Function::begin_strip, "STRIPBEG", "", 0, false, 0,
     "the next image begins a new strip. Completed when it has begun"},
    {Function::end_strip, "STRIPEND", "", 0, false, 0, "ends the open strip. Completed when it has ended"},
    {Function::refine_product, "REFINE", "u32 keyframe", 4, false, 0,
     "the products of a keyframe go down before others. Completed when this is noted"},
    {Function::delete_product, "PRODDEL", "u32 keyframe, u8 kind (0 depth, 1 image)", 5, false, 0,
     "gives up a product that is on board. Completed when it is gone"},
    {Function::begin_pass, "PASSBEG", "u32 length in s", 4, false, 0,
     "contact from now on for so long, in addition to the pass schedule"},
    {Function::end_pass, "PASSEND", "", 0, false, 0,
     "no contact until the next pass begins (without passes: until the present window of 120 s has ended)"},
    {Function::safe_mode, "SAFEMODE", "u8 on (1) or off (0)", 1, false, 0,
     "images at the safe interval only, no depth maps, no products: sets flight.safe_mode"},
    {Function::restart_component, "RESTART", "u8 number of the component", 1, false, 0,
     "a component forgets what it has in memory and goes on from its checkpoint. Completed when it has"},
    {Function::suspend_transfer, "XFERSUSP", "u32 transaction sequence number, 0 for all", 4, false, 0,
     "a file on its way down stays where it is. Completed when this is noted"},
    {Function::resume_transfer, "XFERRESU", "u32 transaction sequence number, 0 for all", 4, false, 0,
     "a suspended file goes on. Completed when this is noted"},
    {Function::cancel_transfer, "XFERCANC", "u32 transaction sequence number, 0 for all", 4, false, 0,
     "a file on its way down is given up: a product counts as lost after its confirmation timeout. Completed when this "
     "is noted"},
    {Function::activate_file, "ACTIVATE", "u32 number of the uplinked file", 4, false, 0,
     "the parameters of an uplinked file are set, all or none"},
};

}  // namespace

std::span<const FunctionInfo> function_table() {
  return table;
}

const FunctionInfo* find_function(const char* name) {
  for (const FunctionInfo& info : table) {
    if (std::strcmp(info.name, name) == 0) return &info;
  }
  return nullptr;
}

}  // namespace ilp
