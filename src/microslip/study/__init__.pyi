from .schema import Study as Study
