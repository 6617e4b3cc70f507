// Service 20 of the Telecommander: mission parameters, all or none of a request.
#include "fsw/commanding/settings.hpp"
#include "fsw/commanding/telecommander.hpp"
#include "fsw/packets/service_parameters.hpp"

namespace ilp {

Status Telecommander::service_20(const Telecommand& telecommand, Answer& answer, Change& change) {
  if (telecommand.subtype == parameter_management::report) return report_parameters(telecommand, answer);
  if (telecommand.subtype == parameter_management::set) return set_parameters(telecommand, answer, change);
  return {StatusCode::subtype_unknown, telecommand.service, telecommand.subtype};
}

Status Telecommander::report_parameters(const Telecommand& telecommand, Answer& answer) {
  const Tailoring& tailoring = wiring_.writer.settings().tailoring;
  ParameterList list;
  ILP_TRY(decode_parameter_list(tailoring, telecommand.data, list));
  answer.accept();
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (find_parameter(list[i]) == parameter_count()) {
      return {StatusCode::parameter_unknown, list[i], static_cast<std::int64_t>(i)};
    }
  }
  answer.start();
  ByteWriter out(workspace_.report);
  write_count(tailoring.parameter_count, list.size(), out);
  for (const std::uint32_t id : list) {
    const std::size_t index = find_parameter(id);
    out.number(id, tailoring.parameter_id);
    write_value(parameter_info(index).type, parameter_value(work_.wanted, index), out);
  }
  ILP_ASSERT(out.ok(), list.size());
  return answer.report(parameter_management::service, parameter_management::values, out.written());
}

Status Telecommander::set_parameters(const Telecommand& telecommand, Answer& answer, Change& change) {
  const Tailoring& tailoring = wiring_.writer.settings().tailoring;
  ByteReader in(telecommand.data);
  const std::uint32_t count = read_count(tailoring.parameter_count, in);
  if (!in.ok() || count == 0) return {StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())};
  if (count > limits::max_list_items) return {StatusCode::capacity_exceeded, count, limits::max_list_items};
  MissionParameters wanted = work_.wanted;
  Status fault;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto id = static_cast<std::uint32_t>(in.number(tailoring.parameter_id));
    const std::size_t index = find_parameter(id);
    const bool known = in.ok() && index < parameter_count();
    if (in.ok() && !known) {
      // The length of an unknown value is not known, so that the rest of the request cannot be read.
      answer.accept();
      return {StatusCode::parameter_unknown, id, i};
    }
    const double value = known ? read_value(parameter_info(index).type, in) : 0;
    if (!in.ok()) return {StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())};
    if (fault.ok() && !ilp::set_parameter(wanted, index, value).ok())
      fault = {StatusCode::parameter_out_of_range, id, i};
  }
  if (in.left() != 0) return {StatusCode::request_malformed, static_cast<std::int64_t>(in.offset())};
  answer.accept();
  ILP_TRY(fault);
  ILP_TRY(check_together(wanted));
  answer.start();
  return set_all(wanted, change);
}

Status Telecommander::check_together(const MissionParameters& wanted) const {
  ILP_TRY(validate(wanted));
  return wiring_.configuration != nullptr ? wiring_.configuration->check(wanted, wiring_.clock.now()) : Status{};
}

Status Telecommander::set_one(const char* section, const char* key, double value, Change& change) {
  MissionParameters wanted = work_.wanted;
  const std::size_t index = find_parameter(section, key);
  if (!ilp::set_parameter(wanted, index, value).ok()) {
    return {StatusCode::parameter_out_of_range, parameter_info(index).number};
  }
  return set_all(wanted, change);
}

Status Telecommander::set_all(const MissionParameters& wanted, Change& change) {
  MissionParameters checked = wanted;
  for (std::size_t i = 0; i < parameter_count(); ++i) {
    const double value = parameter_value(wanted, i);
    if (!ilp::set_parameter(checked, i, value).ok()) {
      return {StatusCode::parameter_out_of_range, parameter_info(i).number};
    }
    if (wiring_.configuration != nullptr || value == parameter_value(work_.wanted, i)) continue;
    ILP_TRY(write_setting(wiring_.store, i, value, wiring_.clock.now()));
  }
  ILP_TRY(check_together(wanted));
  if (wiring_.configuration != nullptr) ILP_TRY(wiring_.configuration->write(wanted, wiring_.clock.now()));
  change.wanted = wanted;
  change.set = true;
  return {};
}

}  // namespace ilp
