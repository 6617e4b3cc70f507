// Settings and fixed statements that every connection sends to the server.
#pragma once

#include "hal/store/store_sharing.hpp"

namespace ilp::postgres {

/// Advisory locks have two numbers. The first is this one; the second is 0 for the writers' lock, or a component number
/// for a stage.
inline constexpr const char* lock_class = "4803664";  // "ILP"

// With this isolation level each statement sees what was committed before it. A snapshot for the whole transaction
// would be taken before the lock is granted.
inline constexpr const char* begin_statement = "BEGIN ISOLATION LEVEL READ COMMITTED READ WRITE";
inline constexpr const char* lock_statement = "SELECT pg_advisory_xact_lock(4803664,0)";
inline constexpr const char* commit_statement = "COMMIT";
inline constexpr const char* rollback_statement = "ROLLBACK";

// A transaction that the server synchronises. With it everything before it in the server's log is on the disk.
inline constexpr const char* flush_statement =
    "SELECT set_config('synchronous_commit','on',true),pg_logical_emit_message(true,'ilp','')";

/// Settings of every connection. Commits are asynchronous; flush_statement synchronises them. A process that is cut off
/// holds its locks until the server notices: after 5 s, or after 10 s in the middle of a transaction. The
/// `lock_timeout` of the others is longer.
inline constexpr const char* session_settings[] = {
    "SET default_transaction_isolation='read committed'",
    "SET default_transaction_read_only=off",
    "SET synchronous_commit=off",
    "SET lock_timeout=15000",
    // A statement is planned once, and not again for each set of parameters.
    "SET plan_cache_mode=force_generic_plan",
    "SET jit=off",
    "SET idle_in_transaction_session_timeout=10000",
    "SET idle_session_timeout=0",
    "SET statement_timeout=0",
    "SET tcp_keepalives_idle=2",
    "SET tcp_keepalives_interval=1",
    "SET tcp_keepalives_count=3",
    "SET tcp_user_timeout=5000",
    "SET client_connection_check_interval=1000",
};

}  // namespace ilp::postgres
