#include "hal/store/postgres/rows.hpp"

#include <libpq-fe.h>

#include <bit>

namespace ilp::postgres {
namespace {

// Numbers of types that never change (the server's catalog pg_type).
constexpr Oid type_bytea = 17;
constexpr Oid type_int8 = 20;
constexpr Oid type_text = 25;
constexpr Oid type_float4 = 700;
constexpr Oid type_float8 = 701;

}  // namespace

void Rows::hold(pg_result* result) {
  PQclear(result_);
  result_ = result;
}

int Rows::count() const {
  return result_ != nullptr ? PQntuples(result_) : 0;
}

const std::uint8_t* Rows::value_at(int row, int column) const {
  if (row >= count() || column >= PQnfields(result_) || PQgetisnull(result_, row, column) != 0) return nullptr;
  return reinterpret_cast<const std::uint8_t*>(PQgetvalue(result_, row, column));
}

template <typename Bits, typename Number>
bool Rows::read(int row, int column, std::uint32_t type, Number& value) const {
  const std::uint8_t* const from = value_at(row, column);
  if (from == nullptr || PQftype(result_, column) != type || PQgetlength(result_, row, column) != sizeof(value)) {
    return false;
  }
  Bits bits = 0;
  for (std::size_t i = 0; i < sizeof(bits); ++i) bits = static_cast<Bits>(bits << 8U | from[i]);
  value = std::bit_cast<Number>(bits);
  return true;
}

bool Rows::number(int row, int column, std::int64_t& value) const {
  return read<std::uint64_t>(row, column, type_int8, value);
}

bool Rows::number(int row, int column, float& value) const {
  return read<std::uint32_t>(row, column, type_float4, value);
}

bool Rows::number(int row, int column, double& value) const {
  return read<std::uint64_t>(row, column, type_float8, value);
}

bool Rows::bytes(int row, int column, std::span<const std::uint8_t>& value) const {
  const std::uint8_t* const from = value_at(row, column);
  if (from == nullptr) return false;
  const Oid type = PQftype(result_, column);
  if (type != type_bytea && type != type_text) return false;
  value = {from, static_cast<std::size_t>(PQgetlength(result_, row, column))};
  return true;
}

}  // namespace ilp::postgres
