// An empty store on the server that tests/distributed/with_postgres has started.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "hal/store/postgres/postgres_store.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp::test {

inline std::string environment(const char* name) {
  const char* const value = std::getenv(name);
  return value != nullptr ? value : "";
}

/// Carries out SQL as superuser and returns what it prints, without the last line end.
std::string sql(const std::string& statements);
/// Without any table.
void empty_database();

struct PostgresBackend {
  std::unique_ptr<PostgresStore> owner = std::make_unique<PostgresStore>();
  PostgresStore& store = *owner;

  PostgresBackend() {
    empty_database();
    EXPECT_OK(store.open(environment("ILP_POSTGRES").c_str(), ~RecordMask{0})) << store.message();
  }
};

}  // namespace ilp::test
