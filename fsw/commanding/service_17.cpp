// Service 17 of the Telecommander: tests of the connection.
#include "fsw/commanding/telecommander.hpp"

namespace ilp {

Status Telecommander::service_17(const Telecommand& telecommand, Answer& answer, Change& change) {
  static_cast<void>(change);
  if (telecommand.subtype == test_service::are_you_alive) {
    if (!telecommand.data.empty()) return {StatusCode::request_malformed, 0};
    answer.start();
    return answer.report(test_service::service, test_service::alive, {});
  }
  if (telecommand.subtype != test_service::connection_test) {
    return {StatusCode::subtype_unknown, telecommand.service, telecommand.subtype};
  }
  std::uint16_t application = 0;
  ILP_TRY(decode_connection(telecommand.data, application));
  answer.accept();
  if (application != wiring_.writer.settings().apid) {
    return {StatusCode::packet_apid, application, wiring_.writer.settings().apid};
  }
  answer.start();
  return answer.report(test_service::service, test_service::connected, telecommand.data);
}

}  // namespace ilp
