# A worker of Ray with motes. Driver and workers need the same Python, Ray and motes:
#
#     docker build --build-arg PACKAGES='motes-fleet[ray,cloud]' -t motes .
#     docker build -f docs/examples/worker.Dockerfile -t registry.example.org/motes-worker .
#
# KubeRay asks workers with wget whether they are well.
ARG MOTES=motes
FROM ${MOTES}
USER root
RUN apt-get update \
    && apt-get install --yes --no-install-recommends wget \
    && rm -rf /var/lib/apt/lists/*
USER motes
RUN ray --version
ENTRYPOINT []
CMD ["ray", "start", "--help"]
