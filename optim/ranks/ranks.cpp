#include "optim/ranks/ranks.h"

#include <cstdlib>
#include <exception>
#include <new>
#include <utility>

#include "renderer/core/error.h"

#if PATHFIT_MPI
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <list>
#include <thread>
#include <vector>

#include <mpi.h>
#endif

namespace pathfit::optim {
namespace {

/// Number of processes by the launcher's word; 0: there is none.
int NumLaunched() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    if (const char* text = std::getenv(name)) return std::atoi(text);
  }
  // Slurm speaks PMIx to steps of `srun --mpi=pmix` only.
  if (std::getenv("PMIX_RANK") != nullptr) {
    const char* tasks = std::getenv("SLURM_STEP_NUM_TASKS");
    return tasks != nullptr ? std::atoi(tasks) : 1;
  }
  return 0;
}

}  // namespace

#if PATHFIT_MPI

namespace {

using std::chrono::microseconds;

enum Tag { kOrder = 1, kStop, kEnd, kResult, kTrouble, kBye };
// MPI counts bytes of a message in an int.
constexpr std::size_t kPiece = std::size_t{1} << 28;
constexpr std::size_t kMostInFlight = std::size_t{1} << 30;

enum class Trouble : int { kCancelled, kNumerical, kInput, kOther };

/// MPI's own waits use a whole processor.
class Pause {
 public:
  void Take() {
    std::this_thread::sleep_for(microseconds(length_));
    length_ = std::min(2 * length_, 1000);
  }

 private:
  int length_ = 16;
};

}  // namespace

struct Ranks::Link {
  struct Sending {
    Bytes bytes;
    std::uint64_t size = 0;
    std::vector<MPI_Request> requests;
  };
  std::list<Sending> sendings;  // MPI reads their bytes
  std::size_t in_flight = 0;
  bool told_cancelled = false;

  static bool IsThere(int source, int tag) {
    int flag = 0;
    MPI_Iprobe(source, tag, MPI_COMM_WORLD, &flag, MPI_STATUS_IGNORE);
    return flag != 0;
  }

  void Send(int to, int tag, Bytes bytes) {
    Sending& s = sendings.emplace_back();
    s.bytes = std::move(bytes);
    s.size = s.bytes.size();
    in_flight += s.bytes.size();
    MPI_Isend(&s.size, 1, MPI_UINT64_T, to, tag, MPI_COMM_WORLD, &s.requests.emplace_back());
    for (std::size_t at = 0; at < s.bytes.size(); at += kPiece) {
      const auto length = static_cast<int>(std::min(kPiece, s.bytes.size() - at));
      MPI_Isend(s.bytes.data() + at,
                length,
                MPI_BYTE,
                to,
                tag,
                MPI_COMM_WORLD,
                &s.requests.emplace_back());
    }
  }

  /// Forgets what has arrived.
  void Progress() {
    std::erase_if(sendings, [&](Sending& s) {
      int done = 0;
      MPI_Testall(
          static_cast<int>(s.requests.size()), s.requests.data(), &done, MPI_STATUSES_IGNORE);
      if (done != 0) in_flight -= s.bytes.size();
      return done != 0;
    });
  }

  static Bytes Receive(int source, int tag) {
    std::uint64_t size = 0;
    MPI_Recv(&size, 1, MPI_UINT64_T, source, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    Bytes bytes(size);
    for (std::size_t at = 0; at < bytes.size(); at += kPiece) {
      const auto length = static_cast<int>(std::min(kPiece, bytes.size() - at));
      MPI_Recv(bytes.data() + at, length, MPI_BYTE, source, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    return bytes;
  }

  /// Takes any piece of a message and drops it; its tag.
  static int Drop(int source) {
    MPI_Status status;
    MPI_Probe(source, MPI_ANY_TAG, MPI_COMM_WORLD, &status);
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    Bytes bytes(static_cast<std::size_t>(size));
    MPI_Recv(
        bytes.data(), size, MPI_BYTE, source, status.MPI_TAG, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return status.MPI_TAG;
  }

  void Report(Trouble kind, const std::string& text) {
    ByteWriter writer;
    writer.Put(kind);
    writer.Put(text);
    Send(0, kTrouble, writer.Take());
  }
};

Ranks::Ranks(int& argc, char**& argv) {
  if (NumLaunched() <= 1) return;
  int provided = 0;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  MPI_Comm_rank(MPI_COMM_WORLD, &index_);
  MPI_Comm_size(MPI_COMM_WORLD, &count_);
  link_ = std::make_unique<Link>();
}

Ranks::~Ranks() {
  if (!link_) return;
  int is_over = 0;
  MPI_Finalized(&is_over);
  if (is_over == 0) MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);  // no End: nobody would wait for us
}

void Ranks::Tell(const Bytes& order) {
  for (int rank = 1; rank < count_; ++rank) link_->Send(rank, kOrder, order);
  if (!link_) return;
  // Networks move long messages only while both sides call MPI, and the first is about to work.
  link_->Progress();
  for (Pause pause; !link_->sendings.empty(); pause.Take()) {
    CheckOthers();
    link_->Progress();
  }
}

void Ranks::CheckOthers() {
  for (int rank = 1; rank < count_; ++rank) {
    if (!Link::IsThere(rank, kTrouble)) continue;
    const Bytes bytes = Link::Receive(rank, kTrouble);
    ByteReader reader(bytes);
    Trouble kind{};
    std::string text;
    reader.Get(kind);
    reader.Get(text);
    text = "rank " + std::to_string(rank) + ": " + text;
    switch (kind) {
      case Trouble::kCancelled:
        throw renderer::Cancelled();
      case Trouble::kNumerical:
        throw renderer::NumericalError(text);
      case Trouble::kInput:
        throw renderer::IoError(text);
      case Trouble::kOther:
        throw std::runtime_error(text);
    }
  }
}

Bytes Ranks::Await(int rank, const renderer::CancelFlag* cancel) {
  for (Pause pause; !Link::IsThere(rank, kResult); pause.Take()) {
    CheckOthers();
    renderer::ThrowIfCancelled(cancel);
    link_->Progress();
  }
  return Link::Receive(rank, kResult);
}

void Ranks::Stop() {
  for (int rank = 1; rank < count_; ++rank) link_->Send(rank, kStop, {});
}

void Ranks::CheckFirst() {
  link_->Progress();
  if (Link::IsThere(0, kStop) || Link::IsThere(0, kEnd)) throw RanksStopped();
}

Bytes Ranks::Hear(const renderer::CancelFlag* cancel) {
  for (Pause pause; !Link::IsThere(0, kOrder); pause.Take()) {
    CheckFirst();
    if (cancel != nullptr && cancel->load() && !link_->told_cancelled) {
      link_->told_cancelled = true;
      link_->Report(Trouble::kCancelled, "");
    }
  }
  CheckFirst();
  return Link::Receive(0, kOrder);
}

void Ranks::Return(Bytes result) {
  link_->Send(0, kResult, std::move(result));
  link_->Progress();
  for (Pause pause; link_->in_flight > kMostInFlight; pause.Take()) CheckFirst();
}

void Ranks::ReportException() {
  if (!link_ || IsFirst()) return;
  try {
    throw;
  } catch (const RanksStopped&) {
  } catch (const renderer::Cancelled&) {
    link_->told_cancelled = true;
    link_->Report(Trouble::kCancelled, "");
  } catch (const renderer::NumericalError& e) {
    link_->Report(Trouble::kNumerical, e.what());
  } catch (const std::bad_alloc&) {
    link_->Report(Trouble::kInput, "out of memory");
  } catch (const std::runtime_error& e) {
    // What only one machine finds wrong is its files.
    link_->Report(Trouble::kInput, e.what());
  } catch (const std::exception& e) {
    link_->Report(Trouble::kOther, e.what());
  }
}

int Ranks::End(int status) {
  if (!link_) return status;
  if (IsFirst()) {
    ByteWriter writer;
    writer.Put(status);
    const Bytes end = writer.Take();
    for (int rank = 1; rank < count_; ++rank) link_->Send(rank, kEnd, end);
    for (int rank = 1; rank < count_; ++rank) {
      Pause pause;
      for (bool is_done = false; !is_done;) {
        link_->Progress();
        if (Link::IsThere(rank, MPI_ANY_TAG)) {
          is_done = Link::Drop(rank) == kBye;
        } else {
          pause.Take();
        }
      }
    }
  } else {
    Pause pause;
    while (!Link::IsThere(0, kEnd)) {
      link_->Progress();
      if (Link::IsThere(0, MPI_ANY_TAG) && !Link::IsThere(0, kEnd)) {
        Link::Drop(0);
      } else {
        pause.Take();
      }
    }
    const Bytes end = Link::Receive(0, kEnd);
    ByteReader(end).Get(status);
    while (Link::IsThere(0, MPI_ANY_TAG)) Link::Drop(0);  // all was sent before
    link_->Send(0, kBye, {});
  }
  for (Pause pause; !link_->sendings.empty(); pause.Take()) link_->Progress();
  MPI_Finalize();
  return status;
}

#else

struct Ranks::Link {};

Ranks::Ranks(int& /*argc*/, char**& /*argv*/) {
  if (NumLaunched() > 1) {
    throw renderer::IoError(
        "started as several processes, but built without MPI (-DPATHFIT_MPI=ON needs "
        "libopenmpi-dev): each would do all the work");
  }
}

Ranks::~Ranks() = default;
void Ranks::Tell(const Bytes& /*order*/) {}
void Ranks::CheckOthers() {}
Bytes Ranks::Await(int /*rank*/, const renderer::CancelFlag* /*cancel*/) { return {}; }
void Ranks::Stop() {}
void Ranks::CheckFirst() {}
Bytes Ranks::Hear(const renderer::CancelFlag* /*cancel*/) { return {}; }
void Ranks::Return(Bytes /*result*/) {}
void Ranks::ReportException() {}
int Ranks::End(int status) { return status; }

#endif

Ranks::Ranks() = default;

}  // namespace pathfit::optim
