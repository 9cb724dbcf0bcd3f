#include "server/import_worker/worker.hpp"

int main(int argc, char** argv) { return fracture::import_worker_main(argc, argv, fracture::import_job); }
