// Service 8 of the Telecommander: functions, each by a record that another component reads, or by a parameter.
#include "cfg/schedule.hpp"
#include "fsw/commanding/telecommander.hpp"
#include "fsw/downlink/delivery_queue.hpp"
#include "fsw/downlink/uplink.hpp"
#include "fsw/link/pass_schedule.hpp"
#include "hal/store/newest_id.hpp"

namespace ilp {
namespace {

// When nothing has become of a request after so long, it has failed.
constexpr TimeNs strip_patience_ns = 600 * ns_per_s;
constexpr TimeNs capture_patience_ns = 60 * ns_per_s;
constexpr TimeNs delete_patience_ns = 600 * ns_per_s;
constexpr TimeNs restart_patience_ns = 10 * ns_per_s;
constexpr std::int64_t longest_pass_s = 1'000'000;

Status bad_argument(std::int64_t number, std::int64_t value) {
  return {StatusCode::invalid_argument, number, value};
}

}  // namespace

Status Telecommander::perform_function(const Telecommand& telecommand, Answer& answer, Work& work) {
  if (telecommand.subtype != function_management::perform) {
    return {StatusCode::subtype_unknown, telecommand.service, telecommand.subtype};
  }
  FunctionCall request;
  ILP_TRY(decode_function(telecommand.data, request));
  answer.accept();
  const FunctionInfo* const function = find_function(request.name);
  if (function == nullptr) return StatusCode::function_unknown;
  ByteReader arguments(request.arguments);
  TimeNs time = 0;
  const TimeFormat& format = writer_.settings().tailoring.time;
  const std::size_t least = function->bytes + (function->has_time ? time_bytes(format) : 0);
  const std::size_t most = least + function->optional;
  const auto came = static_cast<std::int64_t>(request.arguments.size());
  if (request.arguments.size() < least || request.arguments.size() > most) {
    return {StatusCode::function_arguments, came, static_cast<std::int64_t>(least)};
  }
  if (function->has_time) {
    UtcNs utc = 0;
    ILP_TRY(decode_time(format, arguments, utc));
    time = writer_.settings().time.mission(utc);
    const std::size_t behind = arguments.left();
    if (behind < function->bytes || behind > std::size_t{function->bytes} + function->optional) {
      return {StatusCode::function_arguments, came, static_cast<std::int64_t>(least)};
    }
    const TimeNs now = clock_.now();
    if (time < now) return {StatusCode::release_in_past, (now - time) / ns_per_ms};
    if (time - now > farthest_ns) return {StatusCode::time_out_of_range, utc / (seconds_per_day * ns_per_s)};
  }
  return call(*function, time, arguments, answer, work);
}

Status Telecommander::call(const FunctionInfo& function, TimeNs time, ByteReader& arguments, Answer& answer,
                           Work& work) {
  MissionParameters wanted = wanted_;
  const TimeNs now = clock_.now();
  switch (function.function) {
    case Function::capture: {
      const auto tag = static_cast<std::int64_t>(arguments.number(arguments.left()));
      return capture(CommandKind::capture_soon, work.nominal_ns > now ? work.nominal_ns : now, tag, answer, work);
    }
    case Function::capture_at:
      return capture(CommandKind::capture, time, static_cast<std::int64_t>(arguments.number(arguments.left())), answer,
                     work);
    case Function::capture_series:
      return capture_series(time, arguments, answer, work);
    case Function::flush_window:
      return end_strip(OpenKind::flush, answer, work);
    case Function::begin_strip:
      return end_strip(OpenKind::begin_strip, answer, work);
    case Function::end_strip:
      return end_strip(OpenKind::end_strip, answer, work);
    case Function::refine_product:
      return refine(number_of_this_life<KeyframeRecord>(store_, arguments.u32()), work);
    case Function::delete_product:
      return delete_product(arguments, answer, work);
    case Function::restart_component:
      return restart_component(arguments.u8(), answer, work);
    case Function::capture_mode:
      return set_one("acquisition", "capture_mode", arguments.u8(), work);
    case Function::safe_mode:
      return set_one("flight", "safe_mode", arguments.u8(), work);
    case Function::begin_pass: {
      const std::uint32_t length_s = arguments.u32();
      if (length_s == 0 || length_s > longest_pass_s) return bad_argument(1, length_s);
      open_contact(now, length_s, wanted);
      work.way = Configuration::Way::bounded;
      return set_all(wanted, work);
    }
    case Function::end_pass:
      close_contact(now, wanted);
      work.way = Configuration::Way::bounded;
      return set_all(wanted, work);
    case Function::suspend_transfer:
      return wish_transfer(store_, arguments.u32(), TransferWish::suspend);
    case Function::resume_transfer:
      return wish_transfer(store_, arguments.u32(), TransferWish::resume);
    case Function::cancel_transfer:
      return wish_transfer(store_, arguments.u32(), TransferWish::cancel);
    case Function::activate_file:
      ILP_TRY(activate_uplink(store_, number_of_this_life<UplinkRecord>(store_, arguments.u32()), now, wanted));
      work.way = Configuration::Way::file;
      return set_all(wanted, work);
  }
  return StatusCode::function_unknown;
}

Status Telecommander::write_command(CommandRecord command, std::int64_t& id) {
  ILP_TRY(newest_id<CommandRecord>(store_, id));
  command.id = ++id;
  command.time_ns = clock_.now();
  return put(store_, command);
}

Status Telecommander::open(OpenRequest request, Answer& answer, Work& work) {
  request.packet = answer.request().packet;
  request.source = answer.request().source;
  request.ack_flags = answer.ack_flags();
  if (answer.postponed()) request.begin_ns = work.nominal_ns;
  if (!work.after.open.push_back(request)) {
    return {StatusCode::requests_full, static_cast<std::int64_t>(work.after.open.size())};
  }
  answer.start();
  answer.keep_open();
  return {};
}

Status Telecommander::capture(CommandKind kind, TimeNs at, std::int64_t tag, Answer& answer, Work& work) {
  OpenRequest request;
  request.kind = OpenKind::captures;
  request.id = ++work.after.last_request_id;
  request.outstanding = 1;
  request.deadline_ns = at + ns_from_seconds(mission_.capture_timeout_s) + capture_patience_ns;
  CommandRecord command;
  command.kind = kind;
  command.at_ns = at;
  command.request_id = request.id;
  command.tag = tag;
  ILP_TRY(write_command(command, request.subject_id));
  return open(request, answer, work);
}

Status Telecommander::capture_series(TimeNs first, ByteReader& arguments, Answer& answer, Work& work) {
  const std::uint32_t interval_ms = arguments.u32();
  const std::uint16_t number = arguments.u16();
  OpenRequest request;
  request.kind = OpenKind::captures;
  request.id = ++work.after.last_request_id;
  request.interval_ns = interval_ms * ns_per_ms;
  if (number > 1 && request.interval_ns < ns_from_seconds(mission_.capture_min_interval_s)) {
    return bad_argument(2, interval_ms);
  }
  if (number == 0) return bad_argument(3, number);
  if (request.interval_ns > farthest_ns / number) return bad_argument(2, interval_ms);
  request.next_ns = first;
  request.left = number;
  request.deadline_ns =
      first + (number - 1) * request.interval_ns + ns_from_seconds(mission_.capture_timeout_s) + capture_patience_ns;
  return open(request, answer, work);
}

Status Telecommander::end_strip(OpenKind kind, Answer& answer, Work& work) {
  OpenRequest request;
  request.kind = kind;
  request.id = ++work.after.last_request_id;
  request.deadline_ns = clock_.now() + strip_patience_ns;
  CommandRecord command;
  command.kind = CommandKind::end_strip;
  command.reason = StripEnd::commanded;
  command.request_id = request.id;
  ILP_TRY(newest_id<FrameRecord>(store_, command.after_frame_id));
  ILP_TRY(write_command(command, request.subject_id));
  return open(request, answer, work);
}

Status Telecommander::refine(std::int64_t keyframe_id, Work& work) {
  ProductRecord product;
  Status found = get(store_, product_id(keyframe_id, ProductKind::image), product);
  if (found.is(StatusCode::not_found)) found = get(store_, product_id(keyframe_id, ProductKind::depth), product);
  if (found.is(StatusCode::not_found)) return {StatusCode::not_found, keyframe_id};
  ILP_TRY(found);
  CommandRecord command;
  command.kind = CommandKind::refine;
  command.keyframe_id = keyframe_id;
  command.request_id = ++work.after.last_request_id;
  std::int64_t id = 0;
  return write_command(command, id);
}

Status Telecommander::delete_product(ByteReader& arguments, Answer& answer, Work& work) {
  const std::int64_t keyframe_id = number_of_this_life<KeyframeRecord>(store_, arguments.u32());
  const std::uint8_t kind = arguments.u8();
  if (kind >= static_cast<std::uint8_t>(ProductKind::count)) return bad_argument(2, kind);
  OpenRequest request;
  request.kind = OpenKind::delete_product;
  request.id = ++work.after.last_request_id;
  request.subject_id = product_id(keyframe_id, static_cast<ProductKind>(kind));
  request.deadline_ns = clock_.now() + delete_patience_ns;
  ProductRecord product;
  const Status found = get(store_, request.subject_id, product);
  if (found.is(StatusCode::not_found)) return {StatusCode::not_found, request.subject_id};
  ILP_TRY(found);
  CommandRecord command;
  command.kind = CommandKind::delete_product;
  command.subject_id = request.subject_id;
  command.request_id = request.id;
  std::int64_t id = 0;
  ILP_TRY(write_command(command, id));
  return open(request, answer, work);
}

Status Telecommander::restart_component(std::uint8_t number, Answer& answer, Work& work) {
  if (number == 0 || number > stage_count) return bad_argument(1, number);
  OpenRequest request;
  request.kind = OpenKind::restart;
  request.id = ++work.after.last_request_id;
  request.subject_id = number;
  request.deadline_ns = clock_.now() + restart_patience_ns;
  ILP_TRY(newest_id<EventRecord>(store_, request.mark_id));
  CommandRecord command;
  command.kind = CommandKind::restart;
  command.subject_id = number;
  command.request_id = request.id;
  std::int64_t id = 0;
  ILP_TRY(write_command(command, id));
  return open(request, answer, work);
}

}  // namespace ilp
